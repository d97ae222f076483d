/* The test override of the motors: parameters motorPowerSet.* (docs/reference/control-pid.md#14).
 *
 * It acts on every duty that is set, also on those that stop the motors. */
#ifndef CF_BUILTIN_POWER_MOTOR_OVERRIDE_H
#define CF_BUILTIN_POWER_MOTOR_OVERRIDE_H

#include <stdint.h>

#include "api/stabilizer_types.h"
#include "platform.h"
#include "variables.h"

typedef struct {
  // parameters
  uint8_t  enable;    // 1: each motor its own, 2: the first for all, 3: the first, compensated
  uint16_t motor[4];  // [counts]

  float supply_voltage;  // [V], filtered; advances in mode 3 only
} cf_motor_override_t;

// Off, with a filtered supply of 4.2 V.
void cf_motor_override_init(cf_motor_override_t *motor_override);

// Replaces the duties when the override is on. `battery_voltage` [V] is the raw one.
void cf_motor_override_apply(cf_motor_override_t *motor_override, const cf_thrust_curve_t *curve,
                             float battery_voltage, motors_thrust_pwm_t *pwm);

// Table of motorPowerSet, offsets relative to cf_motor_override_t.
cf_variables_t cf_motor_override_parameters(void);

#endif  // CF_BUILTIN_POWER_MOTOR_OVERRIDE_H
