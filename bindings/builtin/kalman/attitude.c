#include "builtin/kalman/attitude.h"

#include <math.h>

#include "builtin/kalman/constants.h"
#include "builtin/math/fast_math.h"

void cf_attitude_turn(float product[4], const float q[4], const float rotation[3]) {
  const float angle =
      sqrtf(rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2]) +
      EPS;
  const float c = cf_fast_cos(angle / 2.0f);
  const float s = cf_fast_sin(angle / 2.0f);

  const float dw = c;
  const float dx = s * rotation[0] / angle;
  const float dy = s * rotation[1] / angle;
  const float dz = s * rotation[2] / angle;

  product[0] = dw * q[0] - dx * q[1] - dy * q[2] - dz * q[3];
  product[1] = dx * q[0] + dw * q[1] + dz * q[2] - dy * q[3];
  product[2] = dy * q[0] - dz * q[1] + dw * q[2] + dx * q[3];
  product[3] = dz * q[0] + dy * q[1] - dx * q[2] + dw * q[3];
}

void cf_attitude_normalize(float q[4], const float unit[4]) {
  const float norm =
      sqrtf(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2] + unit[3] * unit[3]) + EPS;
  for (int k = 0; k < 4; k++) {
    q[k] = unit[k] / norm;
  }
}

void cf_attitude_transition(float block[3][3], const float half[3]) {
  const float d0 = half[0];
  const float d1 = half[1];
  const float d2 = half[2];

  block[0][0] = 1.0f - d1 * d1 / 2.0f - d2 * d2 / 2.0f;
  block[0][1] = d2 + d0 * d1 / 2.0f;
  block[0][2] = -d1 + d0 * d2 / 2.0f;

  block[1][0] = -d2 + d0 * d1 / 2.0f;
  block[1][1] = 1.0f - d0 * d0 / 2.0f - d2 * d2 / 2.0f;
  block[1][2] = d0 + d1 * d2 / 2.0f;

  block[2][0] = d1 + d0 * d2 / 2.0f;
  block[2][1] = -d0 + d1 * d2 / 2.0f;
  block[2][2] = 1.0f - d0 * d0 / 2.0f - d1 * d1 / 2.0f;
}
