#pragma once

#include "stabilizer_types.h"

void controllerBrescianiniInit(void);
bool controllerBrescianiniTest(void);
void controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep);
// PRECISE_LANDING Brescianini
