#ifndef CONTROLLER_BRESCIANINI_H_
#define CONTROLLER_BRESCIANINI_H_

#include "stabilizer_types.h"

void controllerBrescianiniInit(void);
bool controllerBrescianiniTest(void);
void controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep);

#endif  // CONTROLLER_BRESCIANINI_H_
