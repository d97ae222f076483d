#ifndef POSITION_CONTROLLER_INDI_H_
#define POSITION_CONTROLLER_INDI_H_

#include "stabilizer_types.h"

void positionControllerINDIInit(void);
void positionControllerINDI(const sensorData_t *sensors, const setpoint_t *setpoint,
                            const state_t *state, vector_t *refOuterINDI);

#endif  // POSITION_CONTROLLER_INDI_H_
