#include "builtin/battery_compensation.h"

#include <math.h>

#define FULL_COMMAND 65535.0f
#define LOWEST_SUPPLY 2.0f  // [V], below which the motors stay off

// Cardano, for c3 V^3 + c2 V^2 + c1 V + c0 = F, which has one real root:
//   p = -c2 / (3 c3),  r = c1 / (3 c3)
//   q = p^3 + (c2 c1 - 3 c3 (c0 - F)) / (6 c3^2)
//   V = cbrt(q + R) + cbrt(q - R) + p,  R = sqrt(q^2 + (r - p^2)^3)
float cf_battery_motor_voltage(const cf_thrust_curve_t *curve, float thrust_command) {
  const float F = thrust_command / FULL_COMMAND * curve->thrust_max;
  if (F < curve->thrust_min) {
    return 0.0f;
  }

  const float c0 = curve->c0;
  const float c1 = curve->c1;
  const float c2 = curve->c2;
  const float c3 = curve->c3;

  const float p   = -c2 / (3.0f * c3);
  const float q   = p * p * p + (c2 * c1 - 3.0f * c3 * (c0 - F)) / (6.0f * c3 * c3);
  const float r   = c1 / (3.0f * c3);
  const float rp2 = r - p * p;
  const float R   = sqrtf(q * q + rp2 * rp2 * rp2);
  return cbrtf(q + R) + cbrtf(q - R) + p;
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
