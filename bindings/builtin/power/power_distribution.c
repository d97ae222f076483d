#include "builtin/power/power_distribution.h"

#include <stddef.h>
#include <string.h>

#include "api/num.h"
#include "builtin/platform_defaults.h"
#include "builtin/power/battery_compensation.h"
#include "convert.h"
#include "variable_row.h"

#define FULL_COUNT 65535
#define SQRT_HALF 0.707106781f  // lever arm of an x-shaped quadrotor per arm length

cf_status_t cf_power_distribution_init(cf_power_distribution_t *power, cf_platform_t platform) {
  const cf_platform_facts_t    *facts    = cf_platform_facts(platform);
  const cf_platform_defaults_t *defaults = cf_platform_defaults(platform);
  if (facts == NULL || defaults == NULL) {
    return CF_ERR_UNKNOWN;
  }

  // a command of 0 needs 0 V, so the zeros of the solved pairs are true
  *power = (cf_power_distribution_t){
      .arm_length      = facts->arm_length,
      .thrust          = facts->thrust,
      .requires_arming = facts->requires_arming,
      .idle_thrust     = defaults->idle_thrust,
  };
  return CF_OK;
}

// positive roll lifts the left side, positive pitch the nose, positive yaw turns clockwise
static void mix_legacy(const control_t *control, motors_thrust_uncapped_t *uncapped) {
  const float thrust = control->thrust;
  const float r      = (float)(control->roll / 2);
  const float p      = (float)(control->pitch / 2);
  const float y      = (float)control->yaw;

  uncapped->motors.m1 = cf_to_int32(thrust - r + p + y);
  uncapped->motors.m2 = cf_to_int32(thrust - r - p - y);
  uncapped->motors.m3 = cf_to_int32(thrust + r - p + y);
  uncapped->motors.m4 = cf_to_int32(thrust + r + p - y);
}

// inverts thrust and torque of the four rotors; the torques are right-handed
static void mix_force_torque(const cf_power_distribution_t *power, const control_t *control,
                             motors_thrust_uncapped_t *uncapped) {
  const float arm    = SQRT_HALF * power->arm_length;
  const float roll   = 0.25f / arm * control->torqueX;
  const float pitch  = 0.25f / arm * control->torqueY;
  const float thrust = 0.25f * control->thrustSi;
  const float yaw    = 0.25f * control->torqueZ / power->thrust.thrust_to_torque;

  const float forces[4] = {
      thrust - roll - pitch - yaw,
      thrust - roll + pitch + yaw,
      thrust + roll + pitch - yaw,
      thrust + roll - pitch + yaw,
  };
  for (int i = 0; i < 4; i++) {
    const float force = forces[i] < 0.0f ? 0.0f : forces[i];
    uncapped->list[i] = cf_to_int32(force / power->thrust.thrust_max * (float)FULL_COUNT);
  }
}

// each motor by itself
static void mix_forces(const control_t *control, motors_thrust_uncapped_t *uncapped) {
  for (int i = 0; i < 4; i++) {
    const float share = constrain(control->normalizedForces[i], 0.0f, 1.0f);
    uncapped->list[i] = cf_to_int32(share * (float)FULL_COUNT);
  }
}

void cf_power_distribution_update(const cf_power_distribution_t *power, const control_t *control,
                                  motors_thrust_uncapped_t *uncapped) {
  switch (control->controlMode) {
    case controlModeLegacy:
      mix_legacy(control, uncapped);
      break;
    case controlModeForceTorque:
      mix_force_torque(power, control, uncapped);
      break;
    case controlModeForce:
    case controlModePWM:
      mix_forces(control, uncapped);
      break;
    default:
      break;
  }
}

void cf_power_distribution_compensate(cf_power_distribution_t        *power,
                                      const motors_thrust_uncapped_t *uncapped,
                                      float supply_voltage, motors_thrust_uncapped_t *compensated) {
  if (memcmp(uncapped->list, power->solved_command, sizeof power->solved_command) != 0) {
    float commands[4];
    for (int i = 0; i < 4; i++) {
      commands[i] = (float)uncapped->list[i];
    }
    memcpy(power->solved_command, uncapped->list, sizeof power->solved_command);
    cf_battery_motor_voltages(&power->thrust, commands, power->solved_voltage, 4);
  }
  for (int i = 0; i < 4; i++) {
    compensated->list[i] = cf_to_int32(cf_battery_duty(power->solved_voltage[i], supply_voltage));
  }
}

bool cf_power_distribution_cap(const cf_power_distribution_t  *power,
                               const motors_thrust_uncapped_t *uncapped, motors_thrust_pwm_t *pwm) {
  int64_t highest = 0;
  for (int i = 0; i < 4; i++) {
    highest = uncapped->list[i] > highest ? uncapped->list[i] : highest;
  }
  const int64_t reduction = highest > FULL_COUNT ? highest - FULL_COUNT : 0;

  const uint32_t idle = cf_power_distribution_idle_thrust(power);
  for (int i = 0; i < 4; i++) {
    const int64_t reduced = uncapped->list[i] - reduction;
    pwm->list[i]          = (uint16_t)(reduced < idle ? idle : reduced);
  }
  return reduction > 0;
}

uint32_t cf_power_distribution_idle_thrust(const cf_power_distribution_t *power) {
  return power->requires_arming ? power->idle_thrust : 0;
}

float cf_power_distribution_max_thrust(const cf_power_distribution_t *power) {
  return 4.0f * power->thrust.thrust_max;
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("powerDist", "idleThrust", UINT32, CF_CORE | CF_PERSISTENT, cf_power_distribution_t,
           idle_thrust),
};

cf_variables_t cf_power_distribution_parameters(void) {
  return (cf_variables_t){.rows = PARAMETERS, .count = sizeof(PARAMETERS) / sizeof(PARAMETERS[0])};
}
