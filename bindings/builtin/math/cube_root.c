#include "builtin/math/cube_root.h"

#include <stdint.h>
#include <string.h>

// A third of the exponent is a guess within 4 % of the root: bits / 3 + a constant that undoes the
// division of the exponent's bias. Two Halley steps, each of which cubes the error, make it exact
// to the last bits of a double, of which a float keeps less than half.
#define BIAS_OF_GUESS 709958130

static inline double halley(double y, double x) {
  const double cube = y * y * y;
  return y * (cube + 2.0 * x) / (2.0 * cube + x);
}

static inline float cube_root(float x) {
  int32_t bits;
  memcpy(&bits, &x, sizeof bits);
  const int32_t magnitude = bits & 0x7fffffff;
  const int32_t guess     = (int32_t)((float)magnitude * (1.0f / 3.0f)) + BIAS_OF_GUESS;

  float y0;
  float size;
  memcpy(&y0, &guess, sizeof y0);
  memcpy(&size, &magnitude, sizeof size);
  const double y    = halley(halley((double)y0, (double)size), (double)size);
  const float  root = x < 0.0f ? -(float)y : (float)y;

  // zero, infinities and NaN are their own roots
  const int is_ordinary = magnitude > 0 && magnitude < 0x7f800000;
  return is_ordinary ? root : x;
}

void cf_cube_roots(const float *x, float *out, int count) {
  for (int i = 0; i < count; i++) {
    out[i] = cube_root(x[i]);
  }
}
