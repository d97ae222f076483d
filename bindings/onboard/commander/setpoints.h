/* Setpoints as the decoders of the firmware make them from cflib's commands.
 *
 * Each function writes the whole setpoint: members it does not name are 0, modes it does not name
 * are disabled. It returns CF_ERR_VALUE and leaves the setpoint alone when a number in it would not
 * be finite. Angles are degrees, x forward, y left, z up. Pitch is that of setpoint_t, where
 * positive lifts the nose: cflib negates the pitch of its caller in send_setpoint and
 * send_setpoint_manual, and in no other call. Yaw rates are those of cflib's current packets,
 * positive to the left. The legacy command of attitude and thrust lives in rpyt.h.
 *
 * Source: docs/reference/planner-commander.md#9. */
#ifndef CF_ONBOARD_COMMANDER_SETPOINTS_H
#define CF_ONBOARD_COMMANDER_SETPOINTS_H

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

// Are all numbers of a setpoint finite, also those that its modes do not use.
bool cf_setpoint_is_finite(const setpoint_t *setpoint);

#endif  // CF_ONBOARD_COMMANDER_SETPOINTS_H
