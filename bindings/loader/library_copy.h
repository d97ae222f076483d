/* A private copy of a shared object: code and variables of its own at an address of its own.
 *
 * The dynamic loader gives the same object twice when it is asked twice for the same file, so every
 * copy is a new file: in memory, or where the system has no such files, one that is deleted as soon
 * as it is loaded. It cannot be changed behind our back either. */
#ifndef CF_LOADER_LIBRARY_COPY_H
#define CF_LOADER_LIBRARY_COPY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CF_LIBRARY_COPY_REASON_BYTES 128

typedef struct {
  const uint8_t *bytes;  // of the file
  size_t         size;
} cf_library_file_t;

// Loads a copy and returns its handle for dlsym, or null and the reason. Every `serial` is used
// once.
void *cf_library_copy_in_memory(const cf_library_file_t *file, uint32_t serial,
                                char reason[CF_LIBRARY_COPY_REASON_BYTES]);
void *cf_library_copy_on_disk(const cf_library_file_t *file,
                              char                     reason[CF_LIBRARY_COPY_REASON_BYTES]);

// The first of the two that works.
void *cf_library_copy_open(const cf_library_file_t *file, uint32_t serial,
                           char reason[CF_LIBRARY_COPY_REASON_BYTES]);

#endif  // CF_LOADER_LIBRARY_COPY_H
