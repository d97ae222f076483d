#include "bitcraze/own/motor_layer.h"

#include <string.h>

#include "builtin/power/battery_compensation.h"
#include "builtin/power/motor_override.h"
#include "convert.h"
#include "library/image.h"

static cf_thrust_curve_t   curve;
static cf_motor_override_t motor_override;

// the last command of each motor and the voltage solved for it, as the builtin provider keeps them
static int32_t solved_thrust[CF_MOTORS_AT_ONCE];
static float   solved_voltage[CF_MOTORS_AT_ONCE];

void cf_motor_layer_boot(cf_thrust_curve_t of_motors) {
  curve = of_motors;
  cf_motor_override_init(&motor_override);
}

void cf_motor_layer_compensate(const int32_t thrust[4], float supply_voltage, int32_t duty[4]) {
  if (memcmp(thrust, solved_thrust, sizeof solved_thrust) != 0) {
    float commands[CF_MOTORS_AT_ONCE];
    for (int i = 0; i < CF_MOTORS_AT_ONCE; i++) {
      commands[i] = (float)thrust[i];
    }
    memcpy(solved_thrust, thrust, sizeof solved_thrust);
    cf_battery_motor_voltages(&curve, commands, solved_voltage, CF_MOTORS_AT_ONCE);
  }
  for (int i = 0; i < CF_MOTORS_AT_ONCE; i++) {
    duty[i] = cf_to_int32(cf_battery_duty(solved_voltage[i], supply_voltage));
  }
}

int32_t cf_motor_layer_compensate_one(int motor, int32_t thrust, float supply_voltage) {
  if (motor < 0 || motor >= CF_MOTORS_AT_ONCE) {
    return 0;
  }
  if (thrust != solved_thrust[motor]) {
    const float command  = (float)thrust;
    solved_thrust[motor] = thrust;
    cf_battery_motor_voltages(&curve, &command, &solved_voltage[motor], 1);
  }
  return cf_to_int32(cf_battery_duty(solved_voltage[motor], supply_voltage));
}

void cf_motor_layer_override(float battery_voltage, uint16_t duty[4]) {
  motors_thrust_pwm_t pwm;
  memcpy(pwm.list, duty, sizeof pwm.list);
  cf_motor_override_apply(&motor_override, &curve, battery_voltage, &pwm);
  memcpy(duty, pwm.list, sizeof pwm.list);
}

cf_variables_t cf_motor_layer_parameters(void) {
  cf_variables_t table = cf_motor_override_parameters();
  table.base += (uint32_t)cf_image_offset(&motor_override, sizeof motor_override);
  return table;
}
