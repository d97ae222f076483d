// The task of the Kalman filter, seen from the stabilizer loop.
#ifndef __ESTIMATOR_KALMAN_H__
#define __ESTIMATOR_KALMAN_H__

#include <stdint.h>

#include "stabilizer_types.h"

void estimatorKalmanTaskInit();
bool estimatorKalmanTaskTest();

void estimatorKalmanInit(void);
bool estimatorKalmanTest(void);
void estimatorKalman(state_t *state, const stabilizerStep_t stabilizerStep);

void estimatorKalmanGetEstimatedPos(point_t *pos);
void estimatorKalmanGetEstimatedRot(float *rotationMatrix);

#endif  // __ESTIMATOR_KALMAN_H__
