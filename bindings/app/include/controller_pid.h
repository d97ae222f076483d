// The firmware's controller_pid.h for apps: the PID controller of the same drone.
#ifndef CF_APP_CONTROLLER_PID_H
#define CF_APP_CONTROLLER_PID_H

#include <stdbool.h>

#include "stabilizer_types.h"

void controllerPidInit(void);
bool controllerPidTest(void);
void controllerPid(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                   const state_t *state, const stabilizerStep_t stabilizerStep);

#endif  // CF_APP_CONTROLLER_PID_H
