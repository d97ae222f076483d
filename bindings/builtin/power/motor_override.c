#include "builtin/power/motor_override.h"

#include "api/num.h"
#include "builtin/power/battery_compensation.h"
#include "convert.h"
#include "variable_row.h"

#define FULL_BATTERY 4.2f   // [V]
#define FILTER_SHARE 0.01f  // of the new voltage

enum {
  EACH_ITS_OWN      = 1,
  FIRST_FOR_ALL     = 2,
  FIRST_COMPENSATED = 3,
};

void cf_motor_override_init(cf_motor_override_t *motor_override) {
  *motor_override = (cf_motor_override_t){.supply_voltage = FULL_BATTERY};
}

static uint16_t compensated(cf_motor_override_t *motor_override, const cf_thrust_curve_t *curve,
                            float battery_voltage) {
  motor_override->supply_voltage +=
      FILTER_SHARE * (battery_voltage - motor_override->supply_voltage);
  const float duty =
      cf_battery_compensate(curve, (float)motor_override->motor[0], motor_override->supply_voltage);
  return limitUint16(cf_to_int32(duty));
}

static void set_all(motors_thrust_pwm_t *pwm, uint16_t value) {
  for (int i = 0; i < 4; i++) {
    pwm->list[i] = value;
  }
}

void cf_motor_override_apply(cf_motor_override_t *motor_override, const cf_thrust_curve_t *curve,
                             float battery_voltage, motors_thrust_pwm_t *pwm) {
  switch (motor_override->enable) {
    case EACH_ITS_OWN:
      for (int i = 0; i < 4; i++) {
        pwm->list[i] = motor_override->motor[i];
      }
      break;
    case FIRST_FOR_ALL:
      set_all(pwm, motor_override->motor[0]);
      break;
    case FIRST_COMPENSATED:
      set_all(pwm, compensated(motor_override, curve, battery_voltage));
      break;
    default:
      break;
  }
}

#define PARAMETER(name_, type_, member_) \
  CF_ROW("motorPowerSet", name_, type_, CF_CORE, cf_motor_override_t, member_)

static const cf_variable_t PARAMETERS[] = {
    PARAMETER("enable", UINT8, enable), PARAMETER("m1", UINT16, motor[0]),
    PARAMETER("m2", UINT16, motor[1]),  PARAMETER("m3", UINT16, motor[2]),
    PARAMETER("m4", UINT16, motor[3]),
};

cf_variables_t cf_motor_override_parameters(void) {
  return (cf_variables_t){.rows = PARAMETERS, .count = sizeof(PARAMETERS) / sizeof(PARAMETERS[0])};
}
