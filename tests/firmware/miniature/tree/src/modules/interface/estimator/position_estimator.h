#ifndef __POSITION_ESTIMATOR_H__
#define __POSITION_ESTIMATOR_H__

#include "stabilizer_types.h"

void positionEstimate(state_t *estimate, const baro_t *baro, const tofMeasurement_t *tofMeasurement,
                      float dt, stabilizerStep_t stabilizerStep);
void positionUpdateVelocity(float accWZ, float dt);

#endif  // __POSITION_ESTIMATOR_H__
