#include "builtin/kalman/anchors.h"

void kalmanCoreUpdateWithDistance(kalmanCoreData_t *self, const distanceMeasurement_t *d) {
  const cf_linearization_t at = cf_linearize_distance(self->S, d);
  kalmanCoreScalarUpdate(self, at.H, at.error, d->stdDev);
}
