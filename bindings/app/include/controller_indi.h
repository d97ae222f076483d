// The firmware's controller_indi.h for apps: the INDI controller of the same drone.
#ifndef CF_APP_CONTROLLER_INDI_H
#define CF_APP_CONTROLLER_INDI_H

#include <stdbool.h>

#include "label.h"
#include "stabilizer_types.h"

void controllerINDIInit(void) CF_APP_LABEL(controllerINDIInit);
bool controllerINDITest(void) CF_APP_LABEL(controllerINDITest);
void controllerINDI(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                    const state_t *state, const stabilizerStep_t stabilizerStep)
    CF_APP_LABEL(controllerINDI);

#endif  // CF_APP_CONTROLLER_INDI_H
