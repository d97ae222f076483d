// There is a Lee controller, with its state in a struct.
// clang-format off: headers use what comes before
#include "math3d.h"
#include "stabilizer_types.h"
#include "controller_lee.h"
// clang-format on

void probe(controllerLee_t *self, control_t *control, setpoint_t *setpoint, sensorData_t *sensors,
           state_t *state);
void probe(controllerLee_t *self, control_t *control, setpoint_t *setpoint, sensorData_t *sensors,
           state_t *state) {
  controllerLeeInit(self);
  controllerLeeReset(self);
  controllerLee(self, control, setpoint, sensors, state, 2u);
}
