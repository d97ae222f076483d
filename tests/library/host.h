/* What the core is to a provider library, for tests. */
#ifndef HOST_H
#define HOST_H

#include "library/library.h"

// What libraries said since somebody cleared it.
typedef struct {
  char  console[2048];
  char  reason[256];
  int   failures;
  void *drone;  // the block of whoever spoke last
} host_record_t;

// What stands right before the block of every drone.
typedef struct {
  float    height;    // log host.height
  uint8_t  selector;  // parameter host.selector
  uint64_t reserved;
} host_drone_t;

extern cf_library_host_t    host;
extern host_record_t        host_record;
extern const cf_provider_t *host_provider;  // whose variables are found by name

void host_catch_crashes(void);
void host_catch_no_crashes(void);

// Whether somebody could still jump into a function that has returned.
bool host_has_rescue(void);

#endif  // HOST_H
