/* The cascaded PID controller: position -> velocity -> attitude -> rates -> actuators
 * (docs/reference/control-pid.md#11, as of release 2026.08).
 *
 * Gains and limits are members of the two loops, where the parameter tables point. */
#ifndef CF_BUILTIN_CONTROL_CONTROLLER_PID_H
#define CF_BUILTIN_CONTROL_CONTROLLER_PID_H

#include "api/stabilizer_types.h"
#include "builtin/control/attitude_controller.h"
#include "builtin/control/position_controller.h"
#include "platform.h"
#include "status.h"
#include "variables.h"

typedef struct cf_controller_pid {
  cf_attitude_controller_t attitude;
  cf_position_controller_t position;

  // what the outer loops ask of the inner ones, held between their ticks
  attitude_t attitude_desired;  // [deg]
  attitude_t rate_desired;      // [deg/s]
  float      actuator_thrust;   // [counts]

  setpoint_mode_t previous_mode;  // of the last call

  // logs
  float cmd_thrust;  // [counts], of the call before
  float cmd_roll;    // [counts]
  float cmd_pitch;   // [counts]
  float cmd_yaw;     // [counts]
  float r_roll;      // [rad/s]
  float r_pitch;     // [rad/s]
  float r_yaw;       // [rad/s]
  float accelz;      // [g]
} cf_controller_pid_t;

// Writes the whole struct: the state after boot, with the gains of the platform. Returns
// CF_ERR_UNKNOWN, and writes nothing, for an unknown platform.
cf_status_t cf_controller_pid_init(cf_controller_pid_t *pid, cf_platform_t platform);

// What the firmware does when this controller is selected again in flight: the position and
// velocity loops start over with their present gains, the attitude loops and all targets stay.
void cf_controller_pid_reinit(cf_controller_pid_t *pid);

// Computes `control` at one step of the 1 kHz loop. `control` must be the one of the step before:
// attitude outputs change on even steps only and are held in between.
void cf_controller_pid_update(cf_controller_pid_t *pid, control_t *control,
                              const setpoint_t *setpoint, const sensorData_t *sensors,
                              const state_t *state, stabilizerStep_t step);

// The part of the group `controller` that belongs to this controller, offsets relative to
// cf_controller_pid_t. The tables of the two loops are those of their own headers.
cf_variables_t cf_controller_pid_logs(void);

#endif  // CF_BUILTIN_CONTROL_CONTROLLER_PID_H
