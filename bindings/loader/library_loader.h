/* Provider libraries of this process: which there are, and a copy of each for every thread.
 *
 * A library keeps the drone at work in its own variables, so that a copy of it serves one thread.
 * Threads get theirs when they first ask and leave it to others when they end. What was loaded once
 * stays. The registry belongs to the process, as the thread pool does, and not to a drone. */
#ifndef CF_LOADER_LIBRARY_LOADER_H
#define CF_LOADER_LIBRARY_LOADER_H

#include "library/library.h"
#include "provider.h"

#define CF_MAX_LIBRARIES 1023
#define CF_LIBRARY_MESSAGE_BYTES 256
#define CF_LIBRARY_NAME_BYTES 64
#define CF_LIBRARY_MAX_STATE_BYTES 262144  // of a provider block

typedef struct {
  const char    *path;      // of the file; it may change or vanish afterwards
  const char    *name;      // by which drones ask for it, shorter than CF_LIBRARY_NAME_BYTES
  int            platform;  // cf_platform_t, or -1: every one
  cf_image_map_t map;       // is copied
} cf_library_t;

// Loads a library, which from now on is the newest of its name, and hands it the functions of its
// host. Returns its number as a provider, 1 or more; the same file under the same name again gives
// the same number. On failure returns a negative cf_status_t and says why in one sentence.
int cf_library_add(const cf_library_t *library, const cf_library_host_t *host,
                   char message[CF_LIBRARY_MESSAGE_BYTES]);

// Number of libraries that were loaded so far: they are providers 1, 2 and so on.
int cf_library_count(void);

// The table of this thread's copy of library `number`. Null when there is no such library, or no
// copy of it can be made for this thread.
const cf_provider_t *cf_library_table(int number);

// About a library that exists. The bytes are those of a drone's provider block.
const char *cf_library_name(int number);
int         cf_library_platform(int number);
int         cf_library_block_bytes(int number);

// Number of the library of this name that fits the platform, the one that was loaded last; or
// CF_ERR_UNKNOWN.
int cf_library_find(const char *name, int platform);

#endif  // CF_LOADER_LIBRARY_LOADER_H
