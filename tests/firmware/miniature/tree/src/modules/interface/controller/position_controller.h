#ifndef POSITION_CONTROLLER_H_
#define POSITION_CONTROLLER_H_

#include "stabilizer_types.h"

void positionControllerInit();
#if MINIATURE_RELEASE >= 202502
void positionControllerResetAllPID(float xActual, float yActual, float zActual);
#else
void positionControllerResetAllPID();
#endif
void positionControllerResetAllfilters();
void positionController(float *thrust, attitude_t *attitude, const setpoint_t *setpoint,
                        const state_t *state);
void velocityController(float *thrust, attitude_t *attitude, const Axis3f *setpoint_velocity,
                        const state_t *state);

#endif /* POSITION_CONTROLLER_H_ */
