#include "mm_position.h"

void kalmanCoreUpdateWithPosition(kalmanCoreData_t *this, positionMeasurement_t *xyz) {
  for (int i = 0; i < 3; i++) {
    float                   h[KC_STATE_DIM] = {0};
    arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
    h[KC_STATE_X + i]                       = 1;
    kalmanCoreScalarUpdate(this, &H, xyz->pos[i] - this->S[KC_STATE_X + i], xyz->stdDev);
  }
}
