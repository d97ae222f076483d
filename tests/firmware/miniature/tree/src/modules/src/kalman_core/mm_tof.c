#include "mm_tof.h"

void kalmanCoreUpdateWithTof(kalmanCoreData_t *this, tofMeasurement_t *tof) {
  float                   h[KC_STATE_DIM] = {0};
  arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
  if (fabs(this->R[2][2]) > 0.1 && this->R[2][2] > 0) {
#if MINIATURE_RELEASE >= 202608
    float angle = fabsf(acosf(this->R[2][2])) - tof->coneHalfAngle;
#else
    float angle = fabsf(acosf(this->R[2][2])) - DEG_TO_RAD * (15.0f / 2.0f);
#endif
    if (angle < 0.0f) {
      angle = 0.0f;
    }
    const float predicted = this->S[KC_STATE_Z] / cosf(angle);
    h[KC_STATE_Z]         = 1 / cosf(angle);
    kalmanCoreScalarUpdate(this, &H, tof->distance - predicted, tof->stdDev);
  }
}
