/* The firmware's controller.h for apps: the functions that an app brings to fly as controller
 * "OutOfTree", and which controller flies (docs/reference/control-geometric.md#3). */
#ifndef CF_APP_CONTROLLER_H
#define CF_APP_CONTROLLER_H

#include <stdbool.h>

#include "provider.h"
#include "stabilizer_types.h"

// The app's: called when the controller is selected; a false test stops the drone.
void controllerOutOfTreeInit(void);
bool controllerOutOfTreeTest(void);

// The app's: called at 1 kHz while the controller is selected. `control` is that of the call
// before.
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep);

ControllerType controllerGetType(void);
const char    *controllerGetName(void);

#endif  // CF_APP_CONTROLLER_H
