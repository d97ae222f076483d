#include "builtin/kalman/scalar_update.h"

void kalmanCoreUpdateWithAbsoluteHeight(kalmanCoreData_t *self, const heightMeasurement_t *height) {
  const float error = height->height - self->S[KC_STATE_Z];
  cf_scalar_update_single(self, KC_STATE_Z, 1.0f, error, height->stdDev);
}
