#include "api/kalman_core.h"
#include "builtin/kalman/constants.h"
#include "builtin/math/fast_math.h"

static float squared(float x) {
  return x * x;
}

void kalmanCoreInit(kalmanCoreData_t *self, const kalmanCoreParams_t *params, uint32_t nowMs) {
  const float half_yaw = params->initialYaw / 2.0f;
  const float w        = cf_fast_cos(half_yaw);
  const float z        = cf_fast_sin(half_yaw);

  *self = (kalmanCoreData_t){
      .S = {[KC_STATE_X] = params->initialX,
            [KC_STATE_Y] = params->initialY,
            [KC_STATE_Z] = params->initialZ},
      .q = {w, 0.0f, 0.0f, z},

      // even with an initial yaw: finalize brings R in line
      .R = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}},

      .initialQuaternion        = {w, 0.0f, 0.0f, z},
      .lastPredictionMs         = nowMs,
      .lastProcessNoiseUpdateMs = nowMs,
  };

  const float std_dev[KC_STATE_DIM] = {
      params->stdDevInitialPosition_xy,        params->stdDevInitialPosition_xy,
      params->stdDevInitialPosition_z,         params->stdDevInitialVelocity,
      params->stdDevInitialVelocity,           params->stdDevInitialVelocity,
      params->stdDevInitialAttitude_rollpitch, params->stdDevInitialAttitude_rollpitch,
      params->stdDevInitialAttitude_yaw,
  };
  for (int i = 0; i < KC_STATE_DIM; i++) {
    self->P[i][i] = squared(std_dev[i]);
  }
}

void kalmanCoreDecoupleXY(kalmanCoreData_t *self) {
  const int forgotten[4] = {KC_STATE_X, KC_STATE_PX, KC_STATE_Y, KC_STATE_PY};

  for (int n = 0; n < 4; n++) {
    const int i = forgotten[n];
    for (int j = 0; j < KC_STATE_DIM; j++) {
      self->P[i][j] = 0.0f;
      self->P[j][i] = 0.0f;
    }
    self->P[i][i] = MAX_COVARIANCE;
    self->S[i]    = 0.0f;
  }
}
