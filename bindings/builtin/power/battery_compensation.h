/* Thrust to duty: which share of the supply makes a motor push as commanded
 * (docs/reference/control-pid.md#14, current formula). */
#ifndef CF_BUILTIN_POWER_BATTERY_COMPENSATION_H
#define CF_BUILTIN_POWER_BATTERY_COMPENSATION_H

#include "platform.h"

// Returns the duty [0, 65535 and beyond] that makes `thrust_command` [0, 65535] of the curve's
// largest thrust at this supply [V]. Below thrust_min, below 2 V and for a supply that is not a
// number: 0.
float cf_battery_compensate(const cf_thrust_curve_t *curve, float thrust_command,
                            float supply_voltage);

// The expensive half: returns the motor voltage [V] of a command, 0 below thrust_min.
float cf_battery_motor_voltage(const cf_thrust_curve_t *curve, float thrust_command);

// The same for up to CF_MOTORS_AT_ONCE motors, with the same bits and at a fraction of the cost.
#define CF_MOTORS_AT_ONCE 4
void cf_battery_motor_voltages(const cf_thrust_curve_t *curve, const float *thrust_commands,
                               float *motor_voltages, int count);

// The cheap half: returns the duty of a motor voltage [V] at this supply [V].
float cf_battery_duty(float motor_voltage, float supply_voltage);

#endif  // CF_BUILTIN_POWER_BATTERY_COMPENSATION_H
