#ifndef __ESTIMATOR_UKF_H__
#define __ESTIMATOR_UKF_H__

#include "stabilizer_types.h"

void errorEstimatorUkfInit(void);
bool errorEstimatorUkfTest(void);
void errorEstimatorUkf(state_t *state, const stabilizerStep_t stabilizerStep);

void errorEstimatorUkfTaskInit(void);
bool errorEstimatorUkfTaskTest(void);

#endif  // __ESTIMATOR_UKF_H__
