#include "builtin/power/battery_compensation.h"

#include <math.h>

#include "builtin/math/cube_root.h"

#define FULL_COMMAND 65535.0f
#define LOWEST_SUPPLY 2.0f  // [V], below which the motors stay off

// Cardano, for c3 V^3 + c2 V^2 + c1 V + c0 = F, which has one real root:
//   p = -c2 / (3 c3),  r = c1 / (3 c3)
//   q = p^3 + (c2 c1 - 3 c3 (c0 - F)) / (6 c3^2)
//   V = cbrt(q + R) + cbrt(q - R) + p,  R = sqrt(q^2 + (r - p^2)^3)
void cf_battery_motor_voltages(const cf_thrust_curve_t *curve, const float *thrust_commands,
                               float *motor_voltages, int count) {
  const float c0  = curve->c0;
  const float c1  = curve->c1;
  const float c2  = curve->c2;
  const float c3  = curve->c3;
  const float p   = -c2 / (3.0f * c3);
  const float r   = c1 / (3.0f * c3);
  const float rp2 = r - p * p;

  float thrusts[CF_MOTORS_AT_ONCE];
  float terms[2 * CF_MOTORS_AT_ONCE] = {0};
  for (int i = 0; i < count; i++) {
    const float F    = thrust_commands[i] / FULL_COMMAND * curve->thrust_max;
    const float q    = p * p * p + (c2 * c1 - 3.0f * c3 * (c0 - F)) / (6.0f * c3 * c3);
    const float R    = sqrtf(q * q + rp2 * rp2 * rp2);
    thrusts[i]       = F;
    terms[2 * i]     = q + R;
    terms[2 * i + 1] = q - R;
  }
  cf_cube_roots(terms, terms, 2 * count);
  for (int i = 0; i < count; i++) {
    const float voltage = terms[2 * i] + terms[2 * i + 1] + p;
    motor_voltages[i]   = thrusts[i] < curve->thrust_min ? 0.0f : voltage;
  }
}

float cf_battery_motor_voltage(const cf_thrust_curve_t *curve, float thrust_command) {
  float voltage;
  cf_battery_motor_voltages(curve, &thrust_command, &voltage, 1);
  return voltage;
}

float cf_battery_duty(float motor_voltage, float supply_voltage) {
  // negated, so that a supply that is not a number stops the motors as well
  if (!(supply_voltage >= LOWEST_SUPPLY)) {
    return 0.0f;
  }
  return FULL_COMMAND * (motor_voltage / supply_voltage);
}

float cf_battery_compensate(const cf_thrust_curve_t *curve, float thrust_command,
                            float supply_voltage) {
  return cf_battery_duty(cf_battery_motor_voltage(curve, thrust_command), supply_voltage);
}
