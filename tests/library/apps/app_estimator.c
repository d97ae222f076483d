// The estimator of the test app: counts what is in the queue, and knows the height.

#include "estimator.h"
#include "estimator_complementary.h"
#include "log.h"
#include "param.h"

static uint32_t taken;
static uint32_t started;
static uint8_t  forward;

void estimatorOutOfTreeInit(void) {
  started++;
  estimatorComplementaryInit();
}

bool estimatorOutOfTreeTest(void) {
  return started > 0;
}

void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep) {
  if (forward != 0) {
    estimatorComplementary(state, stabilizerStep);
    return;
  }
  measurement_t measurement;
  while (estimatorDequeue(&measurement)) {
    taken++;
    if (measurement.type == MeasurementTypeAbsoluteHeight) {
      state->position.z = measurement.data.height.height;
    }
  }
  state->position.timestamp = stabilizerStep;
}

LOG_GROUP_START(testEstimator)
LOG_ADD(LOG_UINT32, taken, &taken)
LOG_GROUP_STOP(testEstimator)

PARAM_GROUP_START(testEstimator)
PARAM_ADD(PARAM_UINT8, forward, &forward)
PARAM_GROUP_STOP(testEstimator)
