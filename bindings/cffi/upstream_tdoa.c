#include "cffi/upstream_tdoa.h"

#include <math.h>

#include "builtin/kalman/anchors.h"

float kalmanCoreTdoaInnovation(const kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa) {
  const cf_linearization_t at = cf_linearize_tdoa(self->S, tdoa);
  return at.has_derivative ? at.error : NAN;
}

void kalmanCoreUpdateWithTdoaUnfiltered(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa) {
  const cf_linearization_t at = cf_linearize_tdoa(self->S, tdoa);
  if (at.has_derivative) {
    kalmanCoreScalarUpdate(self, at.H, at.error, tdoa->stdDev);
  }
}
