/* Log variables of many drones as they lie in memory, for recorders. */
#ifndef CF_LOG_COPYING_H
#define CF_LOG_COPYING_H

#include <stddef.h>
#include <stdint.h>

#include "crazyflie.h"

// A piece of the memory of a drone.
typedef struct {
  uint32_t offset;  // [bytes], from its start
  uint32_t bytes;
} cf_log_stretch_t;

// Copies some stretches of `count` drones, whose states start `stride` bytes apart, to `to`: one
// behind the other, drone after drone.
void cf_log_copy(const cf_t *first, int count, ptrdiff_t stride, const cf_log_stretch_t *stretches,
                 int stretch_count, uint8_t *to);

#endif  // CF_LOG_COPYING_H
