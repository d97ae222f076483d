#include "builtin/kalman/scalar_update.h"

void kalmanCoreUpdateWithPosition(kalmanCoreData_t *self, const positionMeasurement_t *xyz) {
  for (int i = 0; i < 3; i++) {
    const float error = xyz->pos[i] - self->S[KC_STATE_X + i];
    cf_scalar_update_single(self, KC_STATE_X + i, 1.0f, error, xyz->stdDev);
  }
}
