// clang-format off
#include <math.h>
#include "outlierFilterTdoaSteps.h"
#include "log.h"
// clang-format on

#define LEVELS 5
#define FULL 10
#define ACCEPTANCE_BUCKET_LEVEL 3
#define FILTER_CLOSE_DELAY_COUNT 30
#define NO_LEVEL 100.0f

static struct {
  float acceptanceLevel;
  int   bucket;
} filterLevels[LEVELS] = {{0.4f, 0}, {0.8f, 0}, {1.2f, 0}, {1.6f, 0}, {2.0f, 0}};

static int   previousFilterIndex;
static int   filterCloseDelayCounter;
static float acceptanceLevel;
static float errorDistance;

static float square(float x) {
  return x * x;
}

static bool isPossible(const tdoaMeasurement_t *tdoa) {
  const point_t *a = &tdoa->anchorPositions[0], *b = &tdoa->anchorPositions[1];
  return square(tdoa->distanceDiff) <
         square(a->x - b->x) + square(a->y - b->y) + square(a->z - b->z);
}

static int updateBuckets(float distance) {
  int index = LEVELS;
  for (int i = LEVELS - 1; i >= 0; i--) {
    if (distance < filterLevels[i].acceptanceLevel) {
      filterLevels[i].bucket -= filterLevels[i].bucket > 0;
    } else {
      filterLevels[i].bucket += filterLevels[i].bucket < FULL;
    }
    if (filterLevels[i].bucket < ACCEPTANCE_BUCKET_LEVEL) {
      index = i;
    }
  }
  return index;
}

bool outlierFilterTdoaValidateSteps(const tdoaMeasurement_t *tdoa, const float error,
                                    const vector_t *jacobian, const point_t *estPos) {
  (void)estPos;
  if (!isPossible(tdoa)) {
    return false;
  }
  errorDistance =
      fabsf(error / sqrtf(square(jacobian->x) + square(jacobian->y) + square(jacobian->z)));

  int index = updateBuckets(errorDistance);
  if (index > previousFilterIndex) {
    filterCloseDelayCounter = FILTER_CLOSE_DELAY_COUNT;
  } else if (index < previousFilterIndex && filterCloseDelayCounter > 0) {
    filterCloseDelayCounter--;
    index = previousFilterIndex;
  }
  previousFilterIndex = index;
  acceptanceLevel     = index == LEVELS ? NO_LEVEL : filterLevels[index].acceptanceLevel;
  return index == LEVELS || errorDistance < acceptanceLevel;
}

#ifdef CONFIG_ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK
LOG_GROUP_START(outlierf)
LOG_ADD(LOG_INT32, bucket0, &filterLevels[0].bucket)
LOG_ADD(LOG_INT32, bucket1, &filterLevels[1].bucket)
LOG_ADD(LOG_INT32, bucket2, &filterLevels[2].bucket)
LOG_ADD(LOG_INT32, bucket3, &filterLevels[3].bucket)
LOG_ADD(LOG_INT32, bucket4, &filterLevels[4].bucket)
LOG_ADD(LOG_FLOAT, accLev, &acceptanceLevel)
LOG_ADD(LOG_FLOAT, errD, &errorDistance)
LOG_GROUP_STOP(outlierf)
#endif
