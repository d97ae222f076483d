// The firmware's controller_lee.h for apps: the functions with an instance of one's own, and those
// that work on the instance of the same drone.
#ifndef CF_APP_CONTROLLER_LEE_H
#define CF_APP_CONTROLLER_LEE_H

#include "api/controller_lee.h"

void controllerLeeFirmwareInit(void);
bool controllerLeeFirmwareTest(void);
void controllerLeeFirmware(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep);

#endif  // CF_APP_CONTROLLER_LEE_H
