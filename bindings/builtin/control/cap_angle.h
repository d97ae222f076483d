/* Whole turns off an angle in degrees, as the firmware's controllers do it. Internal to C. */
#ifndef CF_BUILTIN_CONTROL_CAP_ANGLE_H
#define CF_BUILTIN_CONTROL_CAP_ANGLE_H

#include <math.h>

// Returns the angle in [-180, 180], where either end stays where it is. The vehicle subtracts turn
// by turn, which is exact, so one exact remainder gives the same bits and ends for every input.
static inline float cf_cap_angle(float angle) {
  if (angle >= -180.0f && angle <= 180.0f) {
    return angle;
  }
  const float rest = remainderf(angle, 360.0f);
  return fabsf(rest) == 180.0f ? copysignf(180.0f, angle) : rest;
}

#endif  // CF_BUILTIN_CONTROL_CAP_ANGLE_H
