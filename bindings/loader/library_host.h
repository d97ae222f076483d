/* What the core does for a provider library: console, failures, variables, rescue. */
#ifndef CF_LOADER_LIBRARY_HOST_H
#define CF_LOADER_LIBRARY_HOST_H

#include "library/library.h"

// The table for all libraries.
const cf_library_host_t *cf_library_host(void);

#endif  // CF_LOADER_LIBRARY_HOST_H
