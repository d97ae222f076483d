// The firmware's controller_mellinger.h for apps: the functions with an instance of one's own, and
// those that work on the instance of the same drone.
#ifndef CF_APP_CONTROLLER_MELLINGER_H
#define CF_APP_CONTROLLER_MELLINGER_H

#include "api/controller_mellinger.h"

void controllerMellingerFirmwareInit(void);
bool controllerMellingerFirmwareTest(void);
void controllerMellingerFirmware(control_t *control, const setpoint_t *setpoint,
                                 const sensorData_t *sensors, const state_t *state,
                                 const stabilizerStep_t stabilizerStep);

#endif  // CF_APP_CONTROLLER_MELLINGER_H
