/* Battery compensation and the test override motorPowerSet.* of the builtin provider, for the
 * adapter: no type of a checkout or of ours that has the same name. */
#ifndef CF_BITCRAZE_OWN_MOTOR_LAYER_H
#define CF_BITCRAZE_OWN_MOTOR_LAYER_H

#include <stdint.h>

// by their place: a checkout may have headers of the same names
#include "../../platform.h"
#include "../../variables.h"

// State after boot, for motors of this curve.
void cf_motor_layer_boot(cf_thrust_curve_t curve);

// Turns the thrust of four motors into duties for a supply [V].
void cf_motor_layer_compensate(const int32_t thrust[4], float supply_voltage, int32_t duty[4]);

// The same for one motor [0, 3], for code that asks one by one.
int32_t cf_motor_layer_compensate_one(int motor, int32_t thrust, float supply_voltage);

// Replaces four duties when the override is on; battery [V].
void cf_motor_layer_override(float battery_voltage, uint16_t duty[4]);

// Group motorPowerSet, over a block.
cf_variables_t cf_motor_layer_parameters(void);

#endif  // CF_BITCRAZE_OWN_MOTOR_LAYER_H
