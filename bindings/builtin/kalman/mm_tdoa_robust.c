#include "builtin/kalman/robust_update.h"

static cf_linearization_t linearize(const float X[KC_STATE_DIM], const void *measurement) {
  return cf_linearize_tdoa(X, measurement);
}

void kalmanCoreRobustUpdateWithTdoa(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa,
                                    OutlierFilterTdoaState_t *outlierFilterState, float xErr[9]) {
  (void)outlierFilterState;  // odd samples are weighted, not refused

  const cf_robust_model_t model = {
      .measurement_sigma = 2.0f,
      .state_sigma       = 1.5f,
      .linearize         = linearize,
  };
  cf_robust_update(self, &model, tdoa, tdoa->stdDev, xErr);
}
