/* Mellinger and Lee in the form of the vehicle's table of controllers. Their functions take a
 * struct; the one that flies the vehicle is in the checkout's file when that was compiled as for
 * the vehicle, and else here. Internal to the adapter. */
#ifndef CF_BITCRAZE_GEOMETRIC_CONTROLLERS_H
#define CF_BITCRAZE_GEOMETRIC_CONTROLLERS_H

#include "bitcraze/checkout.h"

void cf_geometric_controllers_boot(void);

// Selecting resets the integrals and keeps gains, as on the vehicle.
void cf_mellinger_select(void);
void cf_mellinger_run(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                      const state_t *state, const stabilizerStep_t stabilizerStep);

void cf_lee_select(void);
void cf_lee_run(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                const state_t *state, const stabilizerStep_t stabilizerStep);

#endif  // CF_BITCRAZE_GEOMETRIC_CONTROLLERS_H
