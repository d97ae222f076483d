#include <math.h>

#include "builtin/kalman/outlier_filter_tdoa.h"

#define FULL 10           // the largest count of a bucket
#define USABLE 3          // a level is used while its bucket holds less
#define CLOSE_DELAY 30    // samples before a smaller tolerance may be used
#define WIDE_OPEN 100.0f  // [m], told when every level overflows

static const float LEVELS[CF_TDOA_STEPS] = {0.4f, 0.8f, 1.2f, 1.6f, 2.0f};  // [m]

// A sample within a level takes one out of its bucket, any other puts one in. Returns the smallest
// level that is in use, or CF_TDOA_STEPS when there is none.
static int32_t fill_buckets(int32_t buckets[CF_TDOA_STEPS], float distance) {
  int32_t usable = CF_TDOA_STEPS;
  for (int32_t i = CF_TDOA_STEPS - 1; i >= 0; i--) {
    if (distance < LEVELS[i]) {
      buckets[i] -= buckets[i] > 0 ? 1 : 0;
    } else {
      buckets[i] += buckets[i] < FULL ? 1 : 0;
    }
    if (buckets[i] < USABLE) {
      usable = i;
    }
  }
  return usable;
}

bool outlierFilterTdoaValidateSteps(OutlierFilterTdoaStepsState_t *this,
                                    const tdoaMeasurement_t *tdoa, float error,
                                    const vector_t *jacobian, const point_t *estPos) {
  (void)estPos;
  if (!cf_tdoa_is_possible(tdoa)) {
    return false;
  }

  // the smallest move that would explain the innovation
  const float slope =
      sqrtf(jacobian->x * jacobian->x + jacobian->y * jacobian->y + jacobian->z * jacobian->z);
  this->errorDistance = fabsf(error / slope);

  int32_t level = fill_buckets(this->buckets, this->errorDistance);
  if (level > this->level) {
    this->closeDelay = CLOSE_DELAY;
  } else if (level < this->level && this->closeDelay > 0) {
    this->closeDelay--;
    level = this->level;
  }
  this->level = level;

  if (level == CF_TDOA_STEPS) {
    this->acceptanceLevel = WIDE_OPEN;
    return true;
  }
  this->acceptanceLevel = LEVELS[level];
  return this->errorDistance < this->acceptanceLevel;
}
