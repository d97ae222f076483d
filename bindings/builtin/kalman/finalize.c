#include <math.h>

#include "builtin/kalman/attitude.h"
#include "builtin/kalman/covariance.h"

#define SMALLEST_ERROR 1e-4f  // [rad], smaller attitude errors are thrown away
#define LARGEST_ERROR 10.0f   // [rad], and so are larger ones

static bool is_worth_turning(const float v[3]) {
  const float x = fabsf(v[0]);
  const float y = fabsf(v[1]);
  const float z = fabsf(v[2]);
  return (x > SMALLEST_ERROR || y > SMALLEST_ERROR || z > SMALLEST_ERROR) &&
         (x < LARGEST_ERROR && y < LARGEST_ERROR && z < LARGEST_ERROR);
}

// P = A P A', where A is the identity but for the attitude block.
static void turn_covariance(kalmanCoreData_t *self, const float v[3]) {
  const float half[3] = {v[0] / 2.0f, v[1] / 2.0f, v[2] / 2.0f};
  float       block[3][3];
  cf_attitude_transition(block, half);

  cf_row9_t P[KC_STATE_DIM];
  cf_row9_t T[KC_STATE_DIM];
  cf_covariance_load(P, self);
  for (int i = 0; i < KC_STATE_D0; i++) {
    T[i] = P[i];
  }
  for (int i = 0; i < 3; i++) {
    cf_row9_t row      = cf_row9_times(P[KC_STATE_D0], block[i][0]);
    row                = cf_row9_plus(row, cf_row9_times(P[KC_STATE_D1], block[i][1]));
    row                = cf_row9_plus(row, cf_row9_times(P[KC_STATE_D2], block[i][2]));
    T[KC_STATE_D0 + i] = row;
  }

  // the columns of the attitude errors; the others stay
  for (int i = 0; i < KC_STATE_DIM; i++) {
    const float d0 = T[i].b[2];
    const float d1 = T[i].b[3];
    const float d2 = T[i].c[0];
    T[i].b[2]      = d0 * block[0][0] + d1 * block[0][1] + d2 * block[0][2];
    T[i].b[3]      = d0 * block[1][0] + d1 * block[1][1] + d2 * block[1][2];
    T[i].c[0]      = d0 * block[2][0] + d1 * block[2][1] + d2 * block[2][2];
  }
  cf_covariance_bound(self, T);
}

static void rotation_matrix(float R[3][3], const float q[4]) {
  const float q0 = q[0];
  const float q1 = q[1];
  const float q2 = q[2];
  const float q3 = q[3];

  R[0][0] = q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3;
  R[0][1] = 2.0f * q1 * q2 - 2.0f * q0 * q3;
  R[0][2] = 2.0f * q1 * q3 + 2.0f * q0 * q2;

  R[1][0] = 2.0f * q1 * q2 + 2.0f * q0 * q3;
  R[1][1] = q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3;
  R[1][2] = 2.0f * q2 * q3 - 2.0f * q0 * q1;

  R[2][0] = 2.0f * q1 * q3 - 2.0f * q0 * q2;
  R[2][1] = 2.0f * q2 * q3 + 2.0f * q0 * q1;
  R[2][2] = q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3;
}

bool kalmanCoreFinalize(kalmanCoreData_t *self) {
  if (!self->isUpdated) {
    return false;
  }

  // the attitude error moves into the attitude
  float *v = &self->S[KC_STATE_D0];
  if (is_worth_turning(v)) {
    float turned[4];
    cf_attitude_turn(turned, self->q, v);
    cf_attitude_normalize(self->q, turned);
    turn_covariance(self, v);
  } else {
    cf_covariance_settle(self);
  }
  rotation_matrix(self->R, self->q);

  v[0]            = 0.0f;
  v[1]            = 0.0f;
  v[2]            = 0.0f;
  self->isUpdated = false;
  return true;
}
