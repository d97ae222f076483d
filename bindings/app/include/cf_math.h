// The firmware's cf_math.h for apps, without the matrices of the ARM library.
#ifndef CF_APP_CF_MATH_H
#define CF_APP_CF_MATH_H

#include <math.h>

#include "cfassert.h"

#define DEG_TO_RAD (3.14159265358979323846f / 180.0f)
#define RAD_TO_DEG (180.0f / 3.14159265358979323846f)

#ifndef MIN
#define MIN(a, b) ((b) < (a) ? (b) : (a))
#endif
#ifndef MAX
#define MAX(a, b) ((b) > (a) ? (b) : (a))
#endif

// Limits to zero or more, and to [-1, 1].
static inline float limPos(float in) {
  return in < 0.0f ? 0.0f : in;
}

static inline float clip1(float a) {
  return a < -1.0f ? -1.0f : a > 1.0f ? 1.0f : a;
}

#endif  // CF_APP_CF_MATH_H
