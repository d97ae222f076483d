#include "mm_pose.h"

#include "math3d.h"

void kalmanCoreUpdateWithPose(kalmanCoreData_t *this, poseMeasurement_t *pose) {
  for (int i = 0; i < 3; i++) {
    float                   h[KC_STATE_DIM] = {0};
    arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
    h[KC_STATE_X + i]                       = 1;
    kalmanCoreScalarUpdate(this, &H, pose->pos[i] - this->S[KC_STATE_X + i], pose->stdDevPos);
  }

  // how the measured attitude is turned against the estimated one, in the body frame
  const struct quat a = qinv(mkquat(this->q[1], this->q[2], this->q[3], this->q[0]));
  const struct quat b = mkquat(pose->quat.x, pose->quat.y, pose->quat.z, pose->quat.w);
  const struct quat r = mkquat(
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
  const float s        = 2.0f / r.w;
  const float error[3] = {s * r.x, s * r.y, s * r.z};
  for (int i = 0; i < 3; i++) {
    float                   h[KC_STATE_DIM] = {0};
    arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
    h[KC_STATE_D0 + i]                      = 1;
    kalmanCoreScalarUpdate(this, &H, error[i], pose->stdDevQuat);
  }
}
