#include "builtin/math3d.h"

#include <math.h>

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
