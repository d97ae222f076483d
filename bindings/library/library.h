/* The interface between a provider library and the core.
 *
 * A provider library is a shared object that was compiled on the user's machine: the sources of a
 * checkout, or ours together with the user's own C. Its algorithms keep their state in file-scope
 * variables. Together these are the image of a drone; it lives in the provider block of that drone,
 * and is copied to the place where the code expects it before the code runs, and back afterwards.
 * So the drones of a swarm share the code and nothing else.
 *
 * One copy of a library works for one thread at a time. The core loads a copy for every thread
 * that ticks drones (library_loader.h). Copies lie at different addresses, therefore pointers in a
 * block are stored as offsets from the begin of the library, and made into addresses on the way in.
 * Which words of the image are pointers is known from the debug information of the build. */
#ifndef CF_LIBRARY_LIBRARY_H
#define CF_LIBRARY_LIBRARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "provider.h"

// Changes when this header or provider.h does, so that an old library is refused.
#define CF_LIBRARY_ABI 3

// A piece of the library's memory that belongs to the drone, and not to the code.
typedef struct {
  uint32_t offset;  // [bytes] from the begin of the library
  uint32_t bytes;
} cf_image_range_t;

// Where the file-scope variables of a library are.
typedef struct {
  const cf_image_range_t *ranges;  // in ascending order, apart from each other
  int                     n_ranges;
  const uint32_t         *pointers;  // offsets of words in the ranges that hold a pointer
  int                     n_pointers;
} cf_image_map_t;

// What the code may ask of the drone that it works for, and which `state`, the provider block,
// names.
typedef struct {
  void (*console)(void *state, const char *text);
  // Stops the drone for good and says why; the other drones fly on.
  void (*fail)(void *state, const char *reason);
  // Address of a log variable or a parameter of the drone, and its cf_type_t; null when it has
  // none of that name. Addresses within the block mean the image: see cf_library_variable.
  void *(*log_variable)(void *state, const char *group, const char *name, int *type);
  void *(*parameter)(void *state, const char *group, const char *name, int *type);
  // The reverse: group and name of the log variable, or parameter, at an address that one of the
  // two gave. Returns false when there is none.
  bool (*name_of)(void *state, bool is_log, const void *address, const char **group,
                  const char **name);
  // Where siglongjmp shall go, with the number of the signal, when this thread's code crashes;
  // null: nowhere, the process ends. A sigjmp_buf *.
  void (*set_rescue)(void *rescue);
} cf_library_host_t;

// The one symbol that a library exports, under this name. Called once per copy, before anything
// else. Returns the table of this copy, whose state_bytes is what a block takes, or null when
// `abi` is not the one it was built with. Host and map must outlive the library.
#define CF_LIBRARY_ENTRY "cf_library_open"
typedef const cf_provider_t *(*cf_library_open_t)(int abi, const cf_library_host_t *host,
                                                  const cf_image_map_t *map);

#endif  // CF_LIBRARY_LIBRARY_H
