/* What a client may ask of one Crazyflie, with cflib's vocabulary. Angles are degrees in setpoints
 * and radians in the high-level commander, as in cflib; world frame x forward, y left, z up.
 *
 * Every function returns CF_OK or the reason of the refusal, and changes nothing when it refuses.
 */
#ifndef CF_COMMANDS_H
#define CF_COMMANDS_H

#include "crazyflie.h"
#include "onboard/packets/high_level_packets.h"
#include "onboard/packets/packet.h"

// Hands a setpoint to the commander with the priority of a radio client. CF_ERR_VALUE unless all of
// its numbers are finite, CF_ERR_STATE when a higher priority holds it.
cf_status_t cf_send_setpoint(cf_t *cf, const setpoint_t *setpoint);

// The same for the bytes of a setpoint_t, as a journal or a program keeps them. CF_ERR_VALUE also
// for another size, for a mode that does not exist and for a truth value other than 0 and 1.
cf_status_t cf_send_setpoint_bytes(cf_t *cf, const uint8_t *bytes, uint32_t size);

// The same for some drones of a swarm, whose setpoints stand one behind the other. Returns how many
// were taken: all, or those before the first refusal, of which `status` tells the reason.
int cf_send_setpoints(cf_t *const *drones, const int32_t *numbers, int count,
                      const uint8_t *setpoints, cf_status_t *status);

// The low-level setpoints of onboard/commander/setpoints.h and onboard/commander/rpyt.h, built and
// handed over in one call. What roll, pitch, yaw and thrust of cf_send_rpyt mean is chosen by the
// parameters flightmode.*.
cf_status_t cf_send_stop(cf_t *cf);
cf_status_t cf_send_rpyt(cf_t *cf, float roll, float pitch, float yaw, uint16_t thrust);
cf_status_t cf_send_velocity_world(cf_t *cf, float vx, float vy, float vz, float yaw_rate);
cf_status_t cf_send_zdistance(cf_t *cf, float roll, float pitch, float yaw_rate, float z);
cf_status_t cf_send_altitude_hold(cf_t *cf, float roll, float pitch, float yaw_rate, float vz);
cf_status_t cf_send_hover(cf_t *cf, float vx, float vy, float yaw_rate, float z);
cf_status_t cf_send_position(cf_t *cf, float x, float y, float z, float yaw);
cf_status_t cf_send_full_state(cf_t *cf, const cf_full_state_t *full_state);
cf_status_t cf_send_manual(cf_t *cf, float roll, float pitch, float yaw_rate, uint16_t thrust,
                           bool rate);

// Low-level setpoints have ended: the high-level commander may take over. It must be told what to
// do within its next 10 ms, otherwise the motors stop (docs/reference/planner-commander.md#8.2).
void cf_notify_setpoint_stop(cf_t *cf);

// High-level commander; heights [m], positions [m], yaw [rad], durations [s].
cf_status_t cf_takeoff(cf_t *cf, float height, float duration, float yaw, bool use_current_yaw);
cf_status_t cf_land(cf_t *cf, float height, float duration, float yaw, bool use_current_yaw);
cf_status_t cf_stop(cf_t *cf);
cf_status_t cf_go_to(cf_t *cf, float x, float y, float z, float yaw, float duration, bool relative,
                     bool linear);
cf_status_t cf_takeoff_with_velocity(cf_t *cf, float height, bool height_is_relative,
                                     float velocity, float yaw, bool use_current_yaw);
cf_status_t cf_land_with_velocity(cf_t *cf, float height, bool height_is_relative, float velocity,
                                  float yaw, bool use_current_yaw);
cf_status_t cf_spiral(cf_t *cf, const cf_spiral_t *spiral);
void        cf_set_group_mask(cf_t *cf, uint8_t mask);
cf_status_t cf_write_trajectory(cf_t *cf, uint32_t offset, uint32_t length, const uint8_t *data);
cf_status_t cf_read_trajectory(const cf_t *cf, uint32_t offset, uint32_t length, uint8_t *data);
cf_status_t cf_define_trajectory(cf_t *cf, uint8_t id, uint8_t type, uint32_t offset,
                                 uint8_t n_pieces);
cf_status_t cf_start_trajectory(cf_t *cf, uint8_t id, float timescale, bool relative_position,
                                bool relative_yaw, bool reversed);
bool        cf_is_trajectory_finished(const cf_t *cf);

// A packet of CRTP port 8, as onboard/packets/high_level_packets.h describes it. Returns the number
// of bytes of the reply, 4 or none.
int cf_high_level_packet(cf_t *cf, const uint8_t *data, uint32_t size,
                         uint8_t reply[CF_HIGH_LEVEL_REPLY_BYTES]);

// Supervisor. Arming: CF_ERR_STATE unless the pre-flight checks have passed.
cf_status_t cf_arm(cf_t *cf, bool arm);
cf_status_t cf_recover_from_crash(cf_t *cf);
void        cf_emergency_stop(cf_t *cf);
void        cf_feed_emergency_watchdog(cf_t *cf);

// Stops the motors and locks the drone for good, because the program that commands it has failed;
// the reason, of which the first 191 bytes are kept, shows in onboard.failure.
void cf_fail_pilot(cf_t *cf, const char *reason);

// An external position or pose, as the localization service receives it. CF_ERR_VALUE unless
// finite, CF_ERR_CAPACITY when the estimator's queue is full.
cf_status_t cf_send_external_position(cf_t *cf, float x, float y, float z);
cf_status_t cf_send_external_pose(cf_t *cf, float x, float y, float z, const float quat_xyzw[4]);

// A CRTP packet as a client sends it: setpoints (port 3 channel 0, port 7 channels 0 and 1),
// localization (port 6), high-level commander (port 8) and supervisor (port 9). `reply` takes what
// is to be sent back on the same port and channel. CF_ERR_VALUE for a packet of a wrong length or
// with a number that is not finite (on port 8 the reply says so), CF_ERR_UNKNOWN for a port,
// channel or type that does not exist; otherwise what the command itself returns.
cf_status_t cf_receive_packet(cf_t *cf, uint8_t port, uint8_t channel, const uint8_t *data,
                              int length, cf_packet_reply_t *reply);

// The position of another drone, as the localization service receives it for an id that is not the
// own. CF_ERR_VALUE unless finite and with an id of 1 to 255, CF_ERR_CAPACITY when the table of ten
// is full.
cf_status_t cf_send_peer_position(cf_t *cf, uint8_t id, float x, float y, float z);

#endif  // CF_COMMANDS_H
