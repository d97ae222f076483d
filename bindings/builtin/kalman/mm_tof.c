#include <math.h>

#include "builtin/kalman/scalar_update.h"

void kalmanCoreUpdateWithTof(kalmanCoreData_t *self, const tofMeasurement_t *tof) {
  // compared in double, as the firmware does; NaN is refused
  const float tilt_cosine = self->R[2][2];
  if (!((double)fabsf(tilt_cosine) > 0.1 && tilt_cosine > 0.0f)) {
    return;
  }

  float angle = fabsf(acosf(tilt_cosine)) - tof->coneHalfAngle;
  if (angle < 0.0f) {
    angle = 0.0f;
  }
  const float cosine    = cosf(angle);
  const float predicted = self->S[KC_STATE_Z] / cosine;
  cf_scalar_update_single(self, KC_STATE_Z, 1.0f / cosine, tof->distance - predicted, tof->stdDev);
}
