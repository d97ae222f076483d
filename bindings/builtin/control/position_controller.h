/* Position and velocity loops: meters to m/s, m/s to lean angles and thrust, at 100 Hz
 * (docs/reference/control-pid.md#10).
 *
 * They work in the frame that turns with the vehicle's yaw but stays level, called "body" in the
 * names of the logs. A lean of positive roll drives along -y, of positive (legacy) pitch along -x.
 */
#ifndef CF_BUILTIN_CONTROL_POSITION_CONTROLLER_H
#define CF_BUILTIN_CONTROL_POSITION_CONTROLLER_H

#include <stdint.h>

#include "api/pid.h"
#include "api/stabilizer_types.h"
#include "builtin/platform_defaults.h"
#include "variables.h"

typedef struct {
  PidObject x;   // m -> m/s
  PidObject y;   // m -> m/s
  PidObject z;   // m -> m/s
  PidObject vx;  // m/s -> deg
  PidObject vy;  // m/s -> deg
  PidObject vz;  // m/s -> thousands of counts

  // parameters
  float    roll_max;        // [deg]
  float    pitch_max;       // [deg]
  float    velocity_x_max;  // [m/s]
  float    velocity_y_max;  // [m/s]
  float    velocity_z_max;  // [m/s], taken as 0.5 at least
  uint16_t thrust_base;     // [counts], at which the vertical loop starts
  uint16_t thrust_min;      // [counts]

  // settings without a parameter
  cf_pid_filter_t position_xy_filter;
  cf_pid_filter_t position_z_filter;
  cf_pid_filter_t velocity_xy_filter;
  cf_pid_filter_t velocity_z_filter;

  // logs: the state in the yaw-aligned frame
  float body_x;   // [m]
  float body_y;   // [m]
  float body_vx;  // [m/s]
  float body_vy;  // [m/s]
} cf_position_controller_t;

// Writes the whole struct: the state after boot, with the gains of the platform.
void cf_position_controller_init(cf_position_controller_t     *position,
                                 const cf_platform_defaults_t *defaults);

// Initializes the six PIDs again with the gains that are set now: what selecting the PID controller
// does.
void cf_position_controller_reinit(cf_position_controller_t *position);

// Takes one step of 10 ms. Writes thrust [counts] and the roll and pitch [deg] of `attitude`,
// always, whatever the modes of the setpoint.
void cf_position_controller_update(cf_position_controller_t *position, float *thrust,
                                   attitude_t *attitude, const setpoint_t *setpoint,
                                   const state_t *state);

// The velocity loop alone: `velocity` [m/s] is the target in the yaw-aligned frame.
void cf_position_controller_update_velocity(cf_position_controller_t *position, float *thrust,
                                            attitude_t *attitude, const Axis3f *velocity,
                                            const state_t *state);

// Resets the position PIDs at a position [m] and the velocity PIDs at zero.
void cf_position_controller_reset(cf_position_controller_t *position, float x, float y, float z);

// Clears the memory of the derivative filters.
void cf_position_controller_reset_filters(cf_position_controller_t *position);

// Tables of velCtlPid and posCtlPid (parameters) and posCtl (logs), offsets relative to
// cf_position_controller_t.
cf_variables_t cf_position_controller_parameters(void);
cf_variables_t cf_position_controller_logs(void);

#endif  // CF_BUILTIN_CONTROL_POSITION_CONTROLLER_H
