#include "builtin/kalman/scalar_update.h"

// The rotation from the estimated to the measured attitude, in the body frame: the conjugate of the
// estimate times the measurement (docs/reference/estimators.md#5.8). Neither is normalized.
static quaternion_t attitude_residual(const float q[4], const quaternion_t *measured) {
  const quaternion_t a = {.x = -q[1], .y = -q[2], .z = -q[3], .w = q[0]};
  const quaternion_t b = *measured;

  return (quaternion_t){
      .x = a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      .y = a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
      .z = a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
      .w = a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
  };
}

void kalmanCoreUpdateWithPose(kalmanCoreData_t *self, const poseMeasurement_t *pose) {
  for (int i = 0; i < 3; i++) {
    const float error = pose->pos[i] - self->S[KC_STATE_X + i];
    cf_scalar_update_single(self, KC_STATE_X + i, 1.0f, error, pose->stdDevPos);
  }

  // the division by w makes q and -q the same measurement; half a turn away it is infinite
  const quaternion_t residual = attitude_residual(self->q, &pose->quat);
  const float        scale    = 2.0f / residual.w;
  const float        error[3] = {scale * residual.x, scale * residual.y, scale * residual.z};
  for (int i = 0; i < 3; i++) {
    cf_scalar_update_single(self, KC_STATE_D0 + i, 1.0f, error[i], pose->stdDevQuat);
  }
}
