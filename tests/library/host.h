/* What the core is to a provider library, for tests. */
#ifndef HOST_H
#define HOST_H

#include "library/library.h"

// Output of libraries since the record was cleared.
typedef struct {
  char  console[2048];
  char  reason[256];
  int   failures;
  void *drone;  // the block of the last drone with output
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

// Whether a rescue is armed: after a function has returned, a crash would jump into it.
bool host_has_rescue(void);

#endif  // HOST_H
