/* The table that the core gets: the inner one, made safe.
 *
 * Each function puts the image of its drone in place, calls the inner function and puts the image
 * back, or only calls it between begin and end. When the inner function crashes or gives up, it
 * returns something harmless and the drone is stopped with a reason. */
#ifndef CF_LIBRARY_GUARD_H
#define CF_LIBRARY_GUARD_H

#include "library/library.h"

// Image and captured variables must be open.
const cf_provider_t *cf_guard_open(const cf_library_host_t *host);

#endif  // CF_LIBRARY_GUARD_H
