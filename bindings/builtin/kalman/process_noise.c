#include "builtin/kalman/covariance.h"

// Adds the noise of dt [s] to the diagonal.
static void add_noise(kalmanCoreData_t *self, const kalmanCoreParams_t *params, float dt) {
  const float position_xy =
      params->procNoiseAcc_xy * dt * dt + params->procNoiseVel * dt + params->procNoisePos;
  const float position_z =
      params->procNoiseAcc_z * dt * dt + params->procNoiseVel * dt + params->procNoisePos;
  const float velocity_xy  = params->procNoiseAcc_xy * dt + params->procNoiseVel;
  const float velocity_z   = params->procNoiseAcc_z * dt + params->procNoiseVel;
  const float attitude_rp  = params->measNoiseGyro_rollpitch * dt + params->procNoiseAtt;
  const float attitude_yaw = params->measNoiseGyro_yaw * dt + params->procNoiseAtt;

  self->P[KC_STATE_X][KC_STATE_X] += position_xy * position_xy;
  self->P[KC_STATE_Y][KC_STATE_Y] += position_xy * position_xy;
  self->P[KC_STATE_Z][KC_STATE_Z] += position_z * position_z;
  self->P[KC_STATE_PX][KC_STATE_PX] += velocity_xy * velocity_xy;
  self->P[KC_STATE_PY][KC_STATE_PY] += velocity_xy * velocity_xy;
  self->P[KC_STATE_PZ][KC_STATE_PZ] += velocity_z * velocity_z;
  self->P[KC_STATE_D0][KC_STATE_D0] += attitude_rp * attitude_rp;
  self->P[KC_STATE_D1][KC_STATE_D1] += attitude_rp * attitude_rp;
  self->P[KC_STATE_D2][KC_STATE_D2] += attitude_yaw * attitude_yaw;
}

void kalmanCoreAddProcessNoise(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                               uint32_t nowMs) {
  const float dt = (float)(nowMs - self->lastProcessNoiseUpdateMs) / 1000.0f;
  if (!(dt > 0.0f)) {
    return;
  }
  self->lastProcessNoiseUpdateMs = nowMs;
  add_noise(self, params, dt);
  cf_covariance_settle(self);
}
