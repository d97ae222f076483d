// The firmware's controller_brescianini.h for apps: the Brescianini controller of the same drone.
#ifndef CF_APP_CONTROLLER_BRESCIANINI_H
#define CF_APP_CONTROLLER_BRESCIANINI_H

#include <stdbool.h>

#include "label.h"
#include "stabilizer_types.h"

void controllerBrescianiniInit(void) CF_APP_LABEL(controllerBrescianiniInit);
bool controllerBrescianiniTest(void) CF_APP_LABEL(controllerBrescianiniTest);
void controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep)
    CF_APP_LABEL(controllerBrescianini);

#endif  // CF_APP_CONTROLLER_BRESCIANINI_H
