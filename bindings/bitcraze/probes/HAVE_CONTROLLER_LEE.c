// There is a Lee controller, with its state in a struct.
// clang-format off: headers use what comes before
#include "math3d.h"
#include "stabilizer_types.h"
#include "controller_lee.h"
// clang-format on

void (*const init)(controllerLee_t *)              = controllerLeeInit;
void (*const reset)(controllerLee_t *)             = controllerLeeReset;
void (*const run)(controllerLee_t *, control_t *, const setpoint_t *, const sensorData_t *,
                  const state_t *, const uint32_t) = controllerLee;
