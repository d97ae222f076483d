#ifndef CONTROLLER_INDI_H_
#define CONTROLLER_INDI_H_

#include "stabilizer_types.h"

void controllerINDIInit(void);
bool controllerINDITest(void);
void controllerINDI(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                    const state_t *state, const stabilizerStep_t stabilizerStep);

#endif  // CONTROLLER_INDI_H_
