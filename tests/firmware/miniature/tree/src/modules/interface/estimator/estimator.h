#pragma once

#include "autoconf.h"
#include "stabilizer_types.h"

// MEASUREMENT_TYPES

void stateEstimator(state_t *state, const stabilizerStep_t stabilizerStep);
bool estimatorDequeue(measurement_t *measurement);

#ifdef CONFIG_ESTIMATOR_OOT
void estimatorOutOfTreeInit(void);
bool estimatorOutOfTreeTest(void);
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep);
#endif
