#include <math.h>

#include "builtin/kalman/constants.h"
#include "builtin/kalman/scalar_update.h"

#define HALF_CONE_DEG 7.5f  // the sensor reports the nearest point within a cone of 15 degrees

void kalmanCoreUpdateWithTof(kalmanCoreData_t *self, const tofMeasurement_t *tof) {
  // compared in double, as the firmware does; NaN is refused
  const float tilt_cosine = self->R[2][2];
  if (!((double)fabsf(tilt_cosine) > 0.1 && tilt_cosine > 0.0f)) {
    return;
  }

  float angle = fabsf(acosf(tilt_cosine)) - DEG_TO_RAD * HALF_CONE_DEG;
  if (angle < 0.0f) {
    angle = 0.0f;
  }
  const float cosine    = cosf(angle);
  const float predicted = self->S[KC_STATE_Z] / cosine;
  cf_scalar_update_single(self, KC_STATE_Z, 1.0f / cosine, tof->distance - predicted, tof->stdDev);
}
