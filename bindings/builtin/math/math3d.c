#include "api/math3d.h"

#include <stdint.h>
#include <string.h>

float fsqr(float x) {
  return x * x;
}

float radians(float degrees_) {
  return (M_PI_F / 180.0f) * degrees_;
}

float degrees(float radians_) {
  return (180.0f / M_PI_F) * radians_;
}

float clamp(float value, float min, float max) {
  if (value < min) {
    return min;
  }
  return value > max ? max : value;
}

static int64_t bits_of(float x) {
  int32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

bool fcloseulps(float a, float b, int ulps) {
  if ((a < 0.0f) != (b < 0.0f)) {
    return a == b;
  }
  const int64_t apart = bits_of(a) - bits_of(b);
  return (apart < 0 ? -apart : apart) <= ulps;
}

static float fmodf_floored(float x, float n) {
  return x - floorf(x / n) * n;
}

float normalize_radians(float radians_) {
  const float half_turn = copysignf(M_PI_F, radians_);
  return fmodf(radians_ + half_turn, 2.0f * M_PI_F) - half_turn;
}

float shortest_signed_angle_radians(float start, float goal) {
  return fmodf_floored((goal - start) + M_PI_F, 2.0f * M_PI_F) - M_PI_F;
}
