#include "cffi/upstream_globals.h"

#include <stddef.h>

#include "builtin/control/controller_brescianini.h"
#include "builtin/control/controller_lee.h"
#include "builtin/control/controller_mellinger.h"

cf_status_t cf_upstream_boot(cf_upstream_globals_t *globals, cf_platform_t platform) {
  if (cf_platform_facts(platform) == NULL) {
    return CF_ERR_UNKNOWN;
  }
  *globals = (cf_upstream_globals_t){.platform = platform};
  // a known platform fails nowhere
  (void)cf_controller_pid_init(&globals->pid, platform);
  (void)cf_controller_brescianini_boot(&globals->brescianini, platform);
  (void)cf_power_distribution_init(&globals->power, platform);
  return CF_OK;
}

void cf_upstream_controllerPidInit(cf_upstream_globals_t *globals) {
  if (globals->pid_is_initialized) {
    cf_controller_pid_reinit(&globals->pid);
    return;
  }
  (void)cf_controller_pid_init(&globals->pid, globals->platform);
  globals->pid_is_initialized = true;
}

bool cf_upstream_controllerPidTest(cf_upstream_globals_t *globals) {
  return globals->pid_is_initialized;
}

void cf_upstream_controllerPid(cf_upstream_globals_t *globals, control_t *control,
                               const setpoint_t *setpoint, const sensorData_t *sensors,
                               const state_t *state, stabilizerStep_t stabilizerStep) {
  cf_controller_pid_update(&globals->pid, control, setpoint, sensors, state, stabilizerStep);
}

void cf_upstream_controllerBrescianiniInit(cf_upstream_globals_t *globals) {
  controllerBrescianiniInit(&globals->brescianini);
}

bool cf_upstream_controllerBrescianiniTest(cf_upstream_globals_t *globals) {
  return controllerBrescianiniTest(&globals->brescianini);
}

void cf_upstream_controllerBrescianini(cf_upstream_globals_t *globals, control_t *control,
                                       const setpoint_t *setpoint, const sensorData_t *sensors,
                                       const state_t *state, stabilizerStep_t stabilizerStep) {
  controllerBrescianini(&globals->brescianini, control, setpoint, sensors, state, stabilizerStep);
}

void cf_upstream_controllerMellingerInit(const cf_upstream_globals_t *globals,
                                         controllerMellinger_t       *self) {
  (void)cf_controller_mellinger_init(self, globals->platform);
}

void cf_upstream_controllerLeeInit(const cf_upstream_globals_t *globals, controllerLee_t *self) {
  (void)cf_controller_lee_init(self, globals->platform);
}

void cf_upstream_powerDistributionInit(const cf_upstream_globals_t *globals) {
  (void)globals;
}

bool cf_upstream_powerDistributionTest(const cf_upstream_globals_t *globals) {
  (void)globals;
  return true;
}

void cf_upstream_powerDistribution(const cf_upstream_globals_t *globals, const control_t *control,
                                   motors_thrust_uncapped_t *motorThrustUncapped) {
  cf_power_distribution_update(&globals->power, control, motorThrustUncapped);
}

bool cf_upstream_powerDistributionCap(const cf_upstream_globals_t    *globals,
                                      const motors_thrust_uncapped_t *motorThrustUncapped,
                                      motors_thrust_pwm_t            *motorPwm) {
  return cf_power_distribution_cap(&globals->power, motorThrustUncapped, motorPwm);
}

// every motor drives a rotor
int cf_upstream_powerDistributionMotorType(const cf_upstream_globals_t *globals, uint32_t id) {
  (void)globals;
  (void)id;
  return 1;
}

int cf_upstream_powerDistributionStopRatio(const cf_upstream_globals_t *globals, uint32_t id) {
  (void)globals;
  (void)id;
  return 0;
}

int cf_upstream_powerDistributionGetIdleThrust(const cf_upstream_globals_t *globals) {
  return (int)cf_power_distribution_idle_thrust(&globals->power);
}

float cf_upstream_powerDistributionGetMaxThrust(const cf_upstream_globals_t *globals) {
  return cf_power_distribution_max_thrust(&globals->power);
}
