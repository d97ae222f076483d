/* The parts of kalmanCoreExternalizeState, for callers that cache the costly one. Internal to C. */
#ifndef CF_BUILTIN_KALMAN_EXTERNALIZE_H
#define CF_BUILTIN_KALMAN_EXTERNALIZE_H

#include "api/kalman_core.h"

// Roll, legacy pitch and yaw [deg] of a quaternion w, x, y, z: three inverse functions of libm.
attitude_t cf_attitude_in_degrees(const float q[4]);

// kalmanCoreExternalizeState with the attitude given.
void cf_externalize_state(const kalmanCoreData_t *core, attitude_t attitude, state_t *state,
                          const Axis3f *acc);

#endif  // CF_BUILTIN_KALMAN_EXTERNALIZE_H
