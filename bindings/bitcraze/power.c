/* Mixer, and what the vehicle does between it and the motors.
 *
 * The mixer and its cap are the checkout's. Battery compensation and the test override stand in the
 * checkout's motor driver, among registers and timers, so that they are our own, with the
 * checkout's constants (own/motor_layer.h). */
#include "bitcraze/adapter.h"

#include "power_distribution.h"

#include <string.h>

#include "bitcraze/conversions.h"
#include "bitcraze/own/motor_layer.h"
#include "platform_defaults.h"

#define MOTORS 4
#define FULL_COUNT 65535

// What platform_defaults.h defines for the motors. Releases before late 2025 and platforms without
// measured motors define no thrust curve; the curve of the simulated airframe is used then.
static cf_thrust_curve_t checkout_curve(cf_thrust_curve_t curve) {
#if defined(VMOTOR2THRUST0) && defined(VMOTOR2THRUST1) && defined(VMOTOR2THRUST2) && \
    defined(VMOTOR2THRUST3) && defined(THRUST_MIN)
  if (VMOTOR2THRUST3 != 0.0f) {
    curve.c0         = VMOTOR2THRUST0;
    curve.c1         = VMOTOR2THRUST1;
    curve.c2         = VMOTOR2THRUST2;
    curve.c3         = VMOTOR2THRUST3;
    curve.thrust_min = THRUST_MIN;
  }
#endif
#ifdef THRUST_MAX
  // what a full count of the mixer means
  curve.thrust_max = THRUST_MAX;
#endif
  return curve;
}

void cf_motors_boot(cf_platform_t platform) {
  cf_motor_layer_boot(checkout_curve(cf_platform_facts(platform)->thrust));
}

void cf_power_boot(cf_platform_t platform) {
  cf_motors_boot(platform);
  powerDistributionInit();
}

void cf_power_mix(void *state CF_UNUSED, const api_control_t *control,
                  api_motors_thrust_uncapped_t *uncapped) {
  const control_t          theirs = cf_checkout_control(control);
  motors_thrust_uncapped_t mixed;
  // a mode that the mixer does not know leaves the counts as they are
  memcpy(mixed.list, uncapped->list, sizeof mixed.list);
  powerDistribution(&theirs, &mixed);
  memcpy(uncapped->list, mixed.list, sizeof uncapped->list);
}

void cf_power_compensate(void *state CF_UNUSED, const api_motors_thrust_uncapped_t *uncapped,
                         float supply_voltage, api_motors_thrust_uncapped_t *compensated) {
  cf_motor_layer_compensate(uncapped->list, supply_voltage, compensated->list);
}

bool cf_power_cap(void *state CF_UNUSED, const api_motors_thrust_uncapped_t *uncapped,
                  api_motors_thrust_pwm_t *pwm) {
  motors_thrust_uncapped_t theirs;
  motors_thrust_pwm_t      capped = {.list = {0}};
  memcpy(theirs.list, uncapped->list, sizeof theirs.list);
#if HAVE_POWER_CAP_RESULT
  const bool reduced = powerDistributionCap(&theirs, &capped);
#else
  powerDistributionCap(&theirs, &capped);
  bool reduced = false;
  for (int i = 0; i < MOTORS; i++) {
    reduced = reduced || uncapped->list[i] > FULL_COUNT;
  }
#endif
  memcpy(pwm->list, capped.list, sizeof pwm->list);
  return reduced;
}

uint32_t cf_power_idle_thrust(const void *state CF_UNUSED) {
  return powerDistributionGetIdleThrust();
}

void cf_power_override(void *state CF_UNUSED, float battery_voltage, api_motors_thrust_pwm_t *pwm) {
  cf_motor_layer_override(battery_voltage, pwm->list);
}
