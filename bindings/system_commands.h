/* Commands for a drone whose provider flies the firmware's own commander, high-level commander and
 * supervisor (cf_system_t of provider.h): the commands of commands.h, as packets and requests.
 *
 * The high-level commander gets every command as the packet that a client would send, so that its
 * decoder is a part of what flies. Arguments are checked before, as for our own. */
#ifndef CF_SYSTEM_COMMANDS_H
#define CF_SYSTEM_COMMANDS_H

#include "commands.h"

// The functions of such a provider, for this thread; null for another provider, and when the
// provider of the drone has failed.
const cf_system_t *cf_system_of(const cf_t *cf);

cf_status_t cf_system_set_setpoint(cf_t *cf, const cf_system_t *system, const setpoint_t *setpoint);
cf_status_t cf_system_request(cf_t *cf, cf_system_request_t what);

// Hands a packet to the module of its port. Returns false when none has this port.
bool cf_system_packet(cf_t *cf, uint8_t port, uint8_t channel, const uint8_t *data, int length,
                      cf_packet_reply_t *reply);
int  cf_system_high_level_packet(cf_t *cf, const uint8_t *data, uint32_t size,
                                 uint8_t reply[CF_HIGH_LEVEL_REPLY_BYTES]);

cf_status_t cf_system_takeoff(cf_t *cf, float height, float duration, float yaw,
                              bool use_current_yaw);
cf_status_t cf_system_land(cf_t *cf, float height, float duration, float yaw, bool use_current_yaw);
cf_status_t cf_system_stop(cf_t *cf);
cf_status_t cf_system_go_to(cf_t *cf, float x, float y, float z, float yaw, float duration,
                            bool relative, bool linear);
cf_status_t cf_system_takeoff_with_velocity(cf_t *cf, float height, bool height_is_relative,
                                            float velocity, float yaw, bool use_current_yaw);
cf_status_t cf_system_land_with_velocity(cf_t *cf, float height, bool height_is_relative,
                                         float velocity, float yaw, bool use_current_yaw);
cf_status_t cf_system_spiral(cf_t *cf, const cf_spiral_t *spiral);
void        cf_system_set_group_mask(cf_t *cf, uint8_t mask);
cf_status_t cf_system_define_trajectory(cf_t *cf, uint8_t id, uint8_t type, uint32_t offset,
                                        uint8_t n_pieces);
cf_status_t cf_system_start_trajectory(cf_t *cf, uint8_t id, float timescale,
                                       bool relative_position, bool relative_yaw, bool reversed);
cf_status_t cf_system_write_trajectory(cf_t *cf, uint32_t offset, uint32_t length,
                                       const uint8_t *data);
cf_status_t cf_system_read_trajectory(const cf_t *cf, uint32_t offset, uint32_t length,
                                      uint8_t *data);

#endif  // CF_SYSTEM_COMMANDS_H
