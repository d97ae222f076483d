/* Numbers into integers without undefined behavior. Internal to C.
 *
 * Fractions are cut towards zero, as in a C conversion. What does not fit saturates and NaN becomes
 * 0, which is what the conversion instruction of the vehicle's processor does. */
#ifndef CF_CONVERT_H
#define CF_CONVERT_H

#include <stdint.h>

#define TWO_TO_31 2147483648.0f

static inline int32_t cf_to_int32(float value) {
  if (value >= TWO_TO_31) {
    return INT32_MAX;
  }
  if (value > -TWO_TO_31) {
    return (int32_t)value;
  }
  return value <= -TWO_TO_31 ? INT32_MIN : 0;
}

// An output of a controller: symmetric, because one of them is negated later.
static inline int16_t cf_to_int16(float value) {
  const int32_t whole = cf_to_int32(value);
  if (whole > INT16_MAX) {
    return INT16_MAX;
  }
  return (int16_t)(whole < -INT16_MAX ? -INT16_MAX : whole);
}

#endif  // CF_CONVERT_H
