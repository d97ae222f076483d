/* What the core does for a provider library: console, failures, variables, rescue. */
#ifndef CF_LOADER_LIBRARY_HOST_H
#define CF_LOADER_LIBRARY_HOST_H

#include "loader/library_loader.h"

// The table for all libraries.
const cf_library_host_t *cf_library_host(void);

// Loads a library with this table, see cf_library_add().
int cf_library_load(const cf_library_t *library, char message[CF_LIBRARY_MESSAGE_BYTES]);

#endif  // CF_LOADER_LIBRARY_HOST_H
