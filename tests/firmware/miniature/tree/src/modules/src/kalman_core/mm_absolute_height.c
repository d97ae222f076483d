#include "mm_absolute_height.h"

void kalmanCoreUpdateWithAbsoluteHeight(kalmanCoreData_t *this, heightMeasurement_t *height) {
  float                   h[KC_STATE_DIM] = {0};
  arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
  h[KC_STATE_Z]                           = 1;
  kalmanCoreScalarUpdate(this, &H, height->height - this->S[KC_STATE_Z], height->stdDev);
}
