#ifndef __CONTROLLER_PID_H__
#define __CONTROLLER_PID_H__

#include "stabilizer_types.h"

void controllerPidInit(void);
bool controllerPidTest(void);
void controllerPid(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                   const state_t *state, const stabilizerStep_t stabilizerStep);
// PRECISE_LANDING Pid

#endif  // __CONTROLLER_PID_H__
