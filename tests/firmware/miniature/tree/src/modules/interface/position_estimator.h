#ifndef POSITION_ESTIMATOR_H_
#define POSITION_ESTIMATOR_H_

#include "stabilizer_types.h"

void positionEstimate(state_t *estimate, const baro_t *baro, const tofMeasurement_t *tofMeasurement,
                      float dt, stabilizerStep_t stabilizerStep);
void positionUpdateVelocity(float accWZ, float dt);

#endif  // POSITION_ESTIMATOR_H_
