#include "mm_tdoa_robust.h"

#include "mm_robust.h"

static bool linearize(const float X[N], const void *measurement, float *error, float H[N]) {
  const tdoaMeasurement_t *tdoa = measurement;
  const point_t           *A = &tdoa->anchorPositions[0], *B = &tdoa->anchorPositions[1];
  const float              ax = X[0] - A->x, ay = X[1] - A->y, az = X[2] - A->z;
  const float              bx = X[0] - B->x, by = X[1] - B->y, bz = X[2] - B->z;
  const float              a = sqrtf(ax * ax + ay * ay + az * az);
  const float              b = sqrtf(bx * bx + by * by + bz * bz);
  *error                     = tdoa->distanceDiff - (b - a);
  if (a == 0.0f || b == 0.0f) {
    return false;
  }
  memset(H, 0, sizeof(float[N]));
  H[0] = bx / b - ax / a;
  H[1] = by / b - ay / a;
  H[2] = bz / b - az / a;
  return true;
}

void kalmanCoreRobustUpdateWithTdoa(kalmanCoreData_t *this, tdoaMeasurement_t *tdoa,
                                    OutlierFilterTdoaState_t *outlierFilterState) {
  (void)outlierFilterState;
  robustUpdate(this, linearize, tdoa, tdoa->stdDev, 2.0f, 1.5f);
}
