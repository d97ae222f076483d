/* Functions of the firmware that keep what they remember at file scope, over provider builtin, for
 * scripts that call them by upstream's names (crazychoir_fw.cffirmware).
 *
 * Upstream has one PID controller, one controller of Brescianini and one mixer per process. Here
 * they are a struct, which these functions take in front of upstream's arguments. */
#ifndef CF_CFFI_UPSTREAM_GLOBALS_H
#define CF_CFFI_UPSTREAM_GLOBALS_H

#include <stdbool.h>
#include <stdint.h>

#include "api/controller_brescianini.h"
#include "api/controller_lee.h"
#include "api/controller_mellinger.h"
#include "api/stabilizer_types.h"
#include "builtin/control/controller_pid.h"
#include "builtin/power/power_distribution.h"
#include "platform.h"
#include "status.h"

typedef struct {
  cf_platform_t           platform;
  bool                    pid_is_initialized;
  cf_controller_pid_t     pid;
  controllerBrescianini_t brescianini;
  cf_power_distribution_t power;
} cf_upstream_globals_t;

// Writes the whole struct: what a vehicle of this platform has before main(). Returns
// CF_ERR_UNKNOWN, and writes nothing, for an unknown platform.
cf_status_t cf_upstream_boot(cf_upstream_globals_t *globals, cf_platform_t platform);

// The first call initializes everything; later ones only the position and velocity loops, as in the
// firmware, whose attitude controller is initialized once per process.
void cf_upstream_controllerPidInit(cf_upstream_globals_t *globals);
bool cf_upstream_controllerPidTest(cf_upstream_globals_t *globals);
void cf_upstream_controllerPid(cf_upstream_globals_t *globals, control_t *control,
                               const setpoint_t *setpoint, const sensorData_t *sensors,
                               const state_t *state, stabilizerStep_t stabilizerStep);

void cf_upstream_controllerBrescianiniInit(cf_upstream_globals_t *globals);
bool cf_upstream_controllerBrescianiniTest(cf_upstream_globals_t *globals);
void cf_upstream_controllerBrescianini(cf_upstream_globals_t *globals, control_t *control,
                                       const setpoint_t *setpoint, const sensorData_t *sensors,
                                       const state_t *state, stabilizerStep_t stabilizerStep);

// Their state is the caller's, but mass and thrust belong to the platform.
void cf_upstream_controllerMellingerInit(const cf_upstream_globals_t *globals,
                                         controllerMellinger_t       *self);
void cf_upstream_controllerLeeInit(const cf_upstream_globals_t *globals, controllerLee_t *self);

void  cf_upstream_powerDistributionInit(const cf_upstream_globals_t *globals);
bool  cf_upstream_powerDistributionTest(const cf_upstream_globals_t *globals);
void  cf_upstream_powerDistribution(const cf_upstream_globals_t *globals, const control_t *control,
                                    motors_thrust_uncapped_t *motorThrustUncapped);
bool  cf_upstream_powerDistributionCap(const cf_upstream_globals_t    *globals,
                                       const motors_thrust_uncapped_t *motorThrustUncapped,
                                       motors_thrust_pwm_t            *motorPwm);
int   cf_upstream_powerDistributionMotorType(const cf_upstream_globals_t *globals, uint32_t id);
int   cf_upstream_powerDistributionStopRatio(const cf_upstream_globals_t *globals, uint32_t id);
int   cf_upstream_powerDistributionGetIdleThrust(const cf_upstream_globals_t *globals);
float cf_upstream_powerDistributionGetMaxThrust(const cf_upstream_globals_t *globals);

#endif  // CF_CFFI_UPSTREAM_GLOBALS_H
