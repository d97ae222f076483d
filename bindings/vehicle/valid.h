/* Checks of config numbers. Internal to C. */
#ifndef CF_VEHICLE_VALID_H
#define CF_VEHICLE_VALID_H

#include <stdbool.h>

// NaN is within no range; every config number is far below this bound
#define CF_ANY_SIZE 1.0e6f

static inline bool cf_is_within(float value, float lowest, float highest) {
  return value >= lowest && value <= highest;
}

static inline bool cf_is_positive(float value) {
  return value > 0.0f && value <= CF_ANY_SIZE;
}

static inline bool cf_is_not_negative(float value) {
  return cf_is_within(value, 0.0f, CF_ANY_SIZE);
}

#endif  // CF_VEHICLE_VALID_H
