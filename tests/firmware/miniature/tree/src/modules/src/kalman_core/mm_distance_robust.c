#include "mm_distance_robust.h"

#include "mm_robust.h"

static bool linearize(const float X[N], const void *measurement, float *error, float H[N]) {
  const distanceMeasurement_t *d  = measurement;
  const float                  dx = X[0] - d->x, dy = X[1] - d->y, dz = X[2] - d->z;
  const float                  predicted = sqrtf(dx * dx + dy * dy + dz * dz);
  memset(H, 0, sizeof(float[N]));
  *error = d->distance - predicted;
  H[0]   = predicted != 0.0f ? dx / predicted : 1.0f;
  H[1]   = predicted != 0.0f ? dy / predicted : 0.0f;
  H[2]   = predicted != 0.0f ? dz / predicted : 0.0f;
  return true;
}

void kalmanCoreRobustUpdateWithDistance(kalmanCoreData_t *this, distanceMeasurement_t *d) {
  robustUpdate(this, linearize, d, d->stdDev, 1.5f, 2.0f);
}
