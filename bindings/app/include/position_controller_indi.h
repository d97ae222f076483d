// The firmware's position_controller_indi.h for apps: the outer INDI loop of the same drone.
#ifndef CF_APP_POSITION_CONTROLLER_INDI_H
#define CF_APP_POSITION_CONTROLLER_INDI_H

#include "label.h"
#include "stabilizer_types.h"

void positionControllerINDIInit(void) CF_APP_LABEL(positionControllerINDIInit);
void positionControllerINDI(const sensorData_t *sensors, const setpoint_t *setpoint,
                            const state_t *state, vector_t *refOuterINDI)
    CF_APP_LABEL(positionControllerINDI);

#endif  // CF_APP_POSITION_CONTROLLER_INDI_H
