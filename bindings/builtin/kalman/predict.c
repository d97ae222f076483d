#include <string.h>

#include "builtin/kalman/attitude.h"
#include "builtin/kalman/covariance.h"

// The two blocks of the transition matrix A that are not zero below its first three columns, which
// are those of the identity: rows X to PZ and D0 to D2 by columns PX to D2.
//
//         X  P  D
//     X [ I  .  . ]
//     P [ 0  .  . ]
//     D [ 0  0  . ]
static void transition(float A[KC_STATE_DIM][KC_STATE_DIM], const kalmanCoreData_t *self,
                       const kalmanCoreParams_t *params, const float w[3], float dt) {
  const float (*R)[3] = self->R;
  const float px      = self->S[KC_STATE_PX];
  const float py      = self->S[KC_STATE_PY];
  const float pz      = self->S[KC_STATE_PZ];
  memset(A, 0, sizeof(float[KC_STATE_DIM][KC_STATE_DIM]));

  // position by position, body velocity and attitude error
  for (int i = 0; i < 3; i++) {
    A[i][i]           = 1.0f;
    A[i][KC_STATE_PX] = R[i][0] * dt;
    A[i][KC_STATE_PY] = R[i][1] * dt;
    A[i][KC_STATE_PZ] = R[i][2] * dt;
    A[i][KC_STATE_D0] = (py * R[i][2] - pz * R[i][1]) * dt;
    A[i][KC_STATE_D1] = (-px * R[i][2] + pz * R[i][0]) * dt;
    A[i][KC_STATE_D2] = (px * R[i][1] - py * R[i][0]) * dt;
  }

  // velocity by velocity: it turns against the body, and drag takes a part
  A[KC_STATE_PX][KC_STATE_PX] = 1.0f - dt * params->dragB_x;
  A[KC_STATE_PX][KC_STATE_PY] = w[2] * dt;
  A[KC_STATE_PX][KC_STATE_PZ] = -w[1] * dt;
  A[KC_STATE_PY][KC_STATE_PX] = -w[2] * dt;
  A[KC_STATE_PY][KC_STATE_PY] = 1.0f - dt * params->dragB_y;
  A[KC_STATE_PY][KC_STATE_PZ] = w[0] * dt;
  A[KC_STATE_PZ][KC_STATE_PX] = w[1] * dt;
  A[KC_STATE_PZ][KC_STATE_PY] = -w[0] * dt;
  A[KC_STATE_PZ][KC_STATE_PZ] = 1.0f - dt * params->dragB_z;

  // velocity by attitude error: gravity seen from a tilted body
  A[KC_STATE_PX][KC_STATE_D1] = GRAVITY_MAGNITUDE * R[2][2] * dt;
  A[KC_STATE_PX][KC_STATE_D2] = -GRAVITY_MAGNITUDE * R[2][1] * dt;
  A[KC_STATE_PY][KC_STATE_D0] = -GRAVITY_MAGNITUDE * R[2][2] * dt;
  A[KC_STATE_PY][KC_STATE_D2] = GRAVITY_MAGNITUDE * R[2][0] * dt;
  A[KC_STATE_PZ][KC_STATE_D0] = GRAVITY_MAGNITUDE * R[2][1] * dt;
  A[KC_STATE_PZ][KC_STATE_D1] = -GRAVITY_MAGNITUDE * R[2][0] * dt;

  // attitude error by attitude error
  const float half[3] = {w[0] * dt / 2.0f, w[1] * dt / 2.0f, w[2] * dt / 2.0f};
  float       block[3][3];
  cf_attitude_transition(block, half);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      A[KC_STATE_D0 + i][KC_STATE_D0 + j] = block[i][j];
    }
  }
}

// P = A P A', without what A lacks: left of its diagonal blocks, and the columns of the identity.
static void predict_covariance(kalmanCoreData_t *self, float A[KC_STATE_DIM][KC_STATE_DIM]) {
  cf_row9_t P[KC_STATE_DIM];
  cf_row9_t A_transposed[KC_STATE_DIM];
  cf_covariance_load(P, self);
  for (int k = KC_STATE_PX; k < KC_STATE_DIM; k++) {
    A_transposed[k] = cf_row9_column(A, k);
  }

  // T = A P
  float T[KC_STATE_DIM][KC_STATE_DIM];
  for (int i = 0; i < KC_STATE_D0; i++) {
    cf_row9_t row = i < KC_STATE_PX ? P[i] : cf_row9_zero();
    for (int k = KC_STATE_PX; k < KC_STATE_DIM; k++) {
      row = cf_row9_plus(row, cf_row9_times(P[k], A[i][k]));
    }
    cf_row9_store(T[i], row);
  }
  for (int i = KC_STATE_D0; i < KC_STATE_DIM; i++) {
    cf_row9_t row = cf_row9_zero();
    for (int k = KC_STATE_D0; k < KC_STATE_DIM; k++) {
      row = cf_row9_plus(row, cf_row9_times(P[k], A[i][k]));
    }
    cf_row9_store(T[i], row);
  }

  // P = T A'
  for (int i = 0; i < KC_STATE_DIM; i++) {
    cf_row9_t row = {{T[i][0], T[i][1], T[i][2], 0.0f}, cf_all4(0.0f), cf_all4(0.0f)};
    for (int k = KC_STATE_PX; k < KC_STATE_DIM; k++) {
      row = cf_row9_plus(row, cf_row9_times(A_transposed[k], T[i][k]));
    }
    cf_row9_store(self->P[i], row);
  }
  self->settled = 0;
}

// x += R displacement, where the body moved by `displacement` [m]; z falls as well.
static void move(kalmanCoreData_t *self, const float displacement[3], float dt2) {
  const float (*R)[3] = self->R;
  const float dx      = displacement[0];
  const float dy      = displacement[1];
  const float dz      = displacement[2];

  self->S[KC_STATE_X] += R[0][0] * dx + R[0][1] * dy + R[0][2] * dz;
  self->S[KC_STATE_Y] += R[1][0] * dx + R[1][1] * dy + R[1][2] * dz;
  self->S[KC_STATE_Z] +=
      R[2][0] * dx + R[2][1] * dy + R[2][2] * dz - GRAVITY_MAGNITUDE * dt2 / 2.0f;
}

// In flight the thrust acts along body z and the accelerometer sees nothing else of interest.
static void predict_flying(kalmanCoreData_t *self, const kalmanCoreParams_t *params, float az,
                           const float w[3], float dt) {
  const float *g_axis = self->R[2];
  const float  dt2    = dt * dt;
  const float  px     = self->S[KC_STATE_PX];
  const float  py     = self->S[KC_STATE_PY];
  const float  pz     = self->S[KC_STATE_PZ];

  const float displacement[3] = {px * dt, py * dt, pz * dt + az * dt2 / 2.0f};
  move(self, displacement, dt2);

  // drag acts on the velocity of the center of pressure, p + w x c
  // (docs/reference/estimators.md#4.4.6: the sign of the second part is not settled there)
  const float ox = w[1] * params->cop_z - w[2] * params->cop_y;
  const float oy = w[2] * params->cop_x - w[0] * params->cop_z;
  const float oz = w[0] * params->cop_y - w[1] * params->cop_x;

  self->S[KC_STATE_PX] += dt * (w[2] * py - w[1] * pz - GRAVITY_MAGNITUDE * g_axis[0] -
                                params->dragB_x * px - params->dragB_x * ox);
  self->S[KC_STATE_PY] += dt * (-w[2] * px + w[0] * pz - GRAVITY_MAGNITUDE * g_axis[1] -
                                params->dragB_y * py - params->dragB_y * oy);
  self->S[KC_STATE_PZ] += dt * (az + w[1] * px - w[0] * py - GRAVITY_MAGNITUDE * g_axis[2] -
                                params->dragB_z * pz - params->dragB_z * oz);
}

// On the ground the whole accelerometer counts.
static void predict_standing(kalmanCoreData_t *self, const Axis3f *acc, const float w[3],
                             float dt) {
  const float *g_axis = self->R[2];
  const float  dt2    = dt * dt;
  const float  px     = self->S[KC_STATE_PX];
  const float  py     = self->S[KC_STATE_PY];
  const float  pz     = self->S[KC_STATE_PZ];

  const float displacement[3] = {
      px * dt + acc->x * dt2 / 2.0f,
      py * dt + acc->y * dt2 / 2.0f,
      pz * dt + acc->z * dt2 / 2.0f,
  };
  move(self, displacement, dt2);

  self->S[KC_STATE_PX] += dt * (acc->x + w[2] * py - w[1] * pz - GRAVITY_MAGNITUDE * g_axis[0]);
  self->S[KC_STATE_PY] += dt * (acc->y - w[2] * px + w[0] * pz - GRAVITY_MAGNITUDE * g_axis[1]);
  self->S[KC_STATE_PZ] += dt * (acc->z + w[1] * px - w[0] * py - GRAVITY_MAGNITUDE * g_axis[2]);
}

// q turns by w dt; on the ground it also leans back to where it started.
static void predict_attitude(kalmanCoreData_t *self, float reversion, const float w[3], float dt) {
  const float rotation[3] = {dt * w[0], dt * w[1], dt * w[2]};
  float       turned[4];
  cf_attitude_turn(turned, self->q, rotation);

  if (reversion != 0.0f) {
    const float keep = 1.0f - reversion;
    for (int k = 0; k < 4; k++) {
      turned[k] = keep * turned[k] + reversion * self->initialQuaternion[k];
    }
  }
  cf_attitude_normalize(self->q, turned);
}

void kalmanCorePredict(kalmanCoreData_t *self, const kalmanCoreParams_t *params, const Axis3f *acc,
                       const Axis3f *gyro, uint32_t nowMs, bool quadIsFlying) {
  const float  dt = (float)(nowMs - self->lastPredictionMs) / 1000.0f;
  const float *w  = gyro->axis;

  // the covariance first: its transition belongs to the state before
  float A[KC_STATE_DIM][KC_STATE_DIM];
  transition(A, self, params, w, dt);
  predict_covariance(self, A);

  if (quadIsFlying) {
    predict_flying(self, params, acc->z, w, dt);
  } else {
    predict_standing(self, acc, w, dt);
  }
  predict_attitude(self, quadIsFlying ? 0.0f : params->attitudeReversion, w, dt);

  self->lastPredictionMs = nowMs;
  self->isUpdated        = true;
}
