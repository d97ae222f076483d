/* Tells when the filter has gone astray (docs/reference/estimators.md#7). */
#ifndef CF_BUILTIN_KALMAN_SUPERVISOR_H
#define CF_BUILTIN_KALMAN_SUPERVISOR_H

#include <stdbool.h>

#include "api/kalman_core.h"

// Limits on each component of the state. Zero or less switches a limit off.
typedef struct {
  float max_position;  // [m]
  float max_velocity;  // [m/s]
} cf_kalman_limits_t;

// Returns 100 m and 10 m/s.
cf_kalman_limits_t cf_kalman_default_limits(void);

// Returns whether position and velocity respect the limits. NaN passes, as on the vehicle: callers
// that have to detect NaN check the estimate itself.
bool cf_kalman_state_is_within(const kalmanCoreData_t *core, const cf_kalman_limits_t *limits);

#endif  // CF_BUILTIN_KALMAN_SUPERVISOR_H
