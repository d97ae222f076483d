#include "builtin/kalman/externalize.h"

#include <math.h>

#include "builtin/kalman/constants.h"

attitude_t cf_attitude_in_degrees(const float q[4]) {
  const float q0 = q[0];
  const float q1 = q[1];
  const float q2 = q[2];
  const float q3 = q[3];

  const float yaw   = atan2f(2.0f * (q1 * q2 + q0 * q3), q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3);
  const float pitch = asinf(-2.0f * (q1 * q3 - q0 * q2));
  const float roll  = atan2f(2.0f * (q2 * q3 + q0 * q1), q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3);

  return (attitude_t){
      .roll  = roll * RAD_TO_DEG,
      .pitch = -pitch * RAD_TO_DEG,  // legacy: positive lifts the nose
      .yaw   = yaw * RAD_TO_DEG,
  };
}

void cf_externalize_state(const kalmanCoreData_t *core, attitude_t attitude, state_t *state,
                          const Axis3f *acc) {
  const float (*R)[3] = core->R;
  const float px      = core->S[KC_STATE_PX];
  const float py      = core->S[KC_STATE_PY];
  const float pz      = core->S[KC_STATE_PZ];

  *state = (state_t){
      .attitude           = attitude,
      .attitudeQuaternion = {.x = core->q[1], .y = core->q[2], .z = core->q[3], .w = core->q[0]},
      .position = {.x = core->S[KC_STATE_X], .y = core->S[KC_STATE_Y], .z = core->S[KC_STATE_Z]},
      .velocity = {.x = R[0][0] * px + R[0][1] * py + R[0][2] * pz,
                   .y = R[1][0] * px + R[1][1] * py + R[1][2] * pz,
                   .z = R[2][0] * px + R[2][1] * py + R[2][2] * pz},
      .acc      = {.x = R[0][0] * acc->x + R[0][1] * acc->y + R[0][2] * acc->z,
                   .y = R[1][0] * acc->x + R[1][1] * acc->y + R[1][2] * acc->z,
                   .z = R[2][0] * acc->x + R[2][1] * acc->y + R[2][2] * acc->z - 1.0f},
  };
}

void kalmanCoreExternalizeState(const kalmanCoreData_t *self, state_t *state, const Axis3f *acc) {
  cf_externalize_state(self, cf_attitude_in_degrees(self->q), state, acc);
}
