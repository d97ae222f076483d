#include "builtin/kalman/mm_tdoa.h"

#include "builtin/kalman/anchors.h"

float cf_mm_tdoa_update(kalmanCoreData_t *core, const tdoaMeasurement_t *tdoa, uint32_t now_ms,
                        OutlierFilterTdoaState_t *filter) {
  const cf_linearization_t at = cf_linearize_tdoa(core->S, tdoa);
  if (at.has_derivative && outlierFilterTdoaValidateIntegrator(filter, tdoa, at.error, now_ms)) {
    kalmanCoreScalarUpdate(core, at.H, at.error, tdoa->stdDev);
  }
  return at.error;
}

void kalmanCoreUpdateWithTdoa(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa, uint32_t nowMs,
                              OutlierFilterTdoaState_t *outlierFilterState) {
  (void)cf_mm_tdoa_update(self, tdoa, nowMs, outlierFilterState);
}
