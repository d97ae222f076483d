/* Setpoints as the decoders of the firmware make them from cflib's commands.
 *
 * Each function writes the whole setpoint: members it does not name are 0, modes it does not name
 * are disabled. It returns CF_ERR_VALUE and leaves the setpoint alone when an argument is not
 * finite. Angles are degrees, x forward, y left, z up. Pitch is that of setpoint_t, where positive
 * lifts the nose: cflib negates the pitch of its caller in send_setpoint and
 * send_setpoint_manual, and in no other call. Yaw rates are those of cflib's current packets,
 * positive to the left, except in cf_setpoint_rpyt.
 *
 * Source: planner-commander dossier sections 9 and 10. */
#ifndef CF_ONBOARD_SETPOINTS_H
#define CF_ONBOARD_SETPOINTS_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "status.h"

// The null setpoint: motors off.
void cf_setpoint_stop(setpoint_t *setpoint);

// Velocity [m/s] in the world frame and yaw rate [deg/s].
cf_status_t cf_setpoint_velocity_world(setpoint_t *setpoint, float vx, float vy, float vz,
                                       float yaw_rate);

// Attitude [deg], yaw rate [deg/s] and height [m].
cf_status_t cf_setpoint_zdistance(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                                  float z);

// Attitude [deg], yaw rate [deg/s] and climb rate [m/s].
cf_status_t cf_setpoint_altitude_hold(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                                      float vz);

// Velocity [m/s] in the yaw-aligned body frame, yaw rate [deg/s] and height [m].
cf_status_t cf_setpoint_hover(setpoint_t *setpoint, float vx, float vy, float yaw_rate, float z);

typedef struct {
  point_t      position;      // [m]
  velocity_t   velocity;      // [m/s]
  acc_t        acceleration;  // [m/s^2], without gravity
  quaternion_t attitude;      // x, y, z, w
  Axis3f       body_rates;    // [rad/s]: cflib's documentation says deg/s, the firmware reads rad/s
} cf_full_state_t;

// Position, velocity, acceleration, attitude and body rates at once.
cf_status_t cf_setpoint_full_state(setpoint_t *setpoint, const cf_full_state_t *full_state);

// Position [m] and yaw [deg].
cf_status_t cf_setpoint_position(setpoint_t *setpoint, float x, float y, float z, float yaw);

// Roll and pitch as angles [deg] or, with `rate`, as rates [deg/s]; yaw rate [deg/s]; thrust in
// [0, 65535].
cf_status_t cf_setpoint_manual(setpoint_t *setpoint, float roll, float pitch, float yaw_rate,
                               uint16_t thrust, bool rate);

// Memory of the roll-pitch-yaw-thrust decoder.
typedef struct {
  bool thrust_is_locked;  // until a thrust of 0 is sent
} cf_rpyt_t;

void cf_rpyt_init(cf_rpyt_t *rpyt);

// Legacy attitude command in the default flight mode: roll and pitch [deg], yaw rate [deg/s,
// positive to the right], thrust in [0, 65535], of which less than 1000 is 0 and more than 60000 is
// 60000. `active_priority` is the commander's. Unlike the others this one keeps members of the
// setpoint that it does not name, as the firmware does: pass the client's last setpoint.
cf_status_t cf_setpoint_rpyt(setpoint_t *setpoint, cf_rpyt_t *rpyt, int active_priority, float roll,
                             float pitch, float yaw_rate, uint16_t thrust);

#endif  // CF_ONBOARD_SETPOINTS_H
