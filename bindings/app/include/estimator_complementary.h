// The firmware's estimator_complementary.h for apps: the complementary estimator of the same drone.
// It empties the queue.
#ifndef CF_APP_ESTIMATOR_COMPLEMENTARY_H
#define CF_APP_ESTIMATOR_COMPLEMENTARY_H

#include <stdbool.h>

#include "stabilizer_types.h"

void estimatorComplementaryInit(void);
bool estimatorComplementaryTest(void);
void estimatorComplementary(state_t *state, const stabilizerStep_t stabilizerStep);

#endif  // CF_APP_ESTIMATOR_COMPLEMENTARY_H
