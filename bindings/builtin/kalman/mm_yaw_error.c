#include "builtin/kalman/scalar_update.h"

void kalmanCoreUpdateWithYawError(kalmanCoreData_t *self, const yawErrorMeasurement_t *error) {
  // state minus measurement, the other way round than everywhere else: senders take it into account
  const float innovation = self->S[KC_STATE_D2] - error->yawError;
  cf_scalar_update_single(self, KC_STATE_D2, 1.0f, innovation, error->stdDev);
}
