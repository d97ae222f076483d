// The firmware's position_controller.h for apps: position and velocity loops of the PID controller
// of the same drone.
#ifndef CF_APP_POSITION_CONTROLLER_H
#define CF_APP_POSITION_CONTROLLER_H

#include "stabilizer_types.h"

void positionControllerInit(void);
void positionControllerResetAllPID(float xActual, float yActual, float zActual);
void positionControllerResetAllfilters(void);
void positionController(float *thrust, attitude_t *attitude, const setpoint_t *setpoint,
                        const state_t *state);
void velocityController(float *thrust, attitude_t *attitude, const Axis3f *setpoint_velocity,
                        const state_t *state);

#endif  // CF_APP_POSITION_CONTROLLER_H
