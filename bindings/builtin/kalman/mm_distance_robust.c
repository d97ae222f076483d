#include "builtin/kalman/robust_update.h"

static cf_linearization_t linearize(const float X[KC_STATE_DIM], const void *measurement) {
  return cf_linearize_distance(X, measurement);
}

void kalmanCoreRobustUpdateWithDistance(kalmanCoreData_t *self, const distanceMeasurement_t *d,
                                        float xErr[9]) {
  const cf_robust_model_t model = {
      .measurement_sigma = 1.5f,
      .state_sigma       = 2.0f,
      .linearize         = linearize,
  };
  cf_robust_update(self, &model, d, d->stdDev, xErr);
}
