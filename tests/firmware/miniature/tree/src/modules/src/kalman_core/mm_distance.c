#include "mm_distance.h"

void kalmanCoreUpdateWithDistance(kalmanCoreData_t *this, distanceMeasurement_t *d) {
  float                   h[KC_STATE_DIM] = {0};
  arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};

  const float dx        = this->S[KC_STATE_X] - d->x;
  const float dy        = this->S[KC_STATE_Y] - d->y;
  const float dz        = this->S[KC_STATE_Z] - d->z;
  const float predicted = arm_sqrt(powf(dx, 2) + powf(dy, 2) + powf(dz, 2));
  if (predicted != 0.0f) {
    h[KC_STATE_X] = dx / predicted;
    h[KC_STATE_Y] = dy / predicted;
    h[KC_STATE_Z] = dz / predicted;
  } else {
    h[KC_STATE_X] = 1.0f;
  }
  kalmanCoreScalarUpdate(this, &H, d->distance - predicted, d->stdDev);
}
