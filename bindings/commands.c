#include "commands.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "system_commands.h"

#define HIGH_LEVEL(cf_, provider_) &(cf_)->onboard.high_level, provider_, (cf_)->provider_state

static uint64_t now_us(const cf_t *cf) {
  return (uint64_t)cf->onboard.tick * 1000;
}

// ---------------------------------------------------------------------------- low-level setpoints

cf_status_t cf_send_setpoint(cf_t *cf, const setpoint_t *setpoint) {
  if (!cf_setpoint_is_finite(setpoint)) {
    return CF_ERR_VALUE;
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  if (provider == NULL) {
    return CF_ERR_STATE;
  }
  cf->onboard.client_setpoint = *setpoint;
  if (provider->system != NULL) {
    return cf_system_set_setpoint(cf, provider->system, setpoint);
  }
  const bool is_taken =
      cf_commander_set_setpoint(&cf->onboard.commander, provider, cf->provider_state, setpoint,
                                COMMANDER_PRIORITY_CRTP, cf->onboard.tick);
  return is_taken ? CF_OK : CF_ERR_STATE;
}

static bool is_mode(stab_mode_t mode) {
  return (int)mode >= modeDisable && (int)mode <= modeVelocity;
}

cf_status_t cf_send_setpoint_bytes(cf_t *cf, const uint8_t *bytes, uint32_t size) {
  setpoint_t setpoint;
  // looked at as a byte, because a bool that is neither 0 nor 1 must not be read
  if (size != sizeof setpoint || bytes[offsetof(setpoint_t, velocity_body)] > 1) {
    return CF_ERR_VALUE;
  }
  memcpy(&setpoint, bytes, sizeof setpoint);
  const setpoint_mode_t *m = &setpoint.mode;
  const bool are_modes     = is_mode(m->x) && is_mode(m->y) && is_mode(m->z) && is_mode(m->roll) &&
                             is_mode(m->pitch) && is_mode(m->yaw) && is_mode(m->quat);
  return are_modes ? cf_send_setpoint(cf, &setpoint) : CF_ERR_VALUE;
}

int cf_send_setpoints(cf_t *const *drones, const int32_t *numbers, int count,
                      const uint8_t *setpoints, cf_status_t *status) {
  *status = CF_OK;
  for (int i = 0; i < count; i++) {
    const uint8_t *bytes = setpoints + (size_t)i * sizeof(setpoint_t);
    *status              = cf_send_setpoint_bytes(drones[numbers[i]], bytes, sizeof(setpoint_t));
    if (*status != CF_OK) {
      return i;
    }
  }
  return count;
}

static cf_status_t send_if(cf_t *cf, cf_status_t status, const setpoint_t *setpoint) {
  return status == CF_OK ? cf_send_setpoint(cf, setpoint) : status;
}

cf_status_t cf_send_stop(cf_t *cf) {
  setpoint_t setpoint;
  cf_setpoint_stop(&setpoint);
  return cf_send_setpoint(cf, &setpoint);
}

cf_status_t cf_send_rpyt(cf_t *cf, float roll, float pitch, float yaw, uint16_t thrust) {
  cf_onboard_t     *onboard  = &cf->onboard;
  setpoint_t        setpoint = onboard->client_setpoint;
  const int         priority = cf_commander_active_priority(&onboard->commander);
  const bool        was_hold = onboard->rpyt.is_holding_altitude;
  const cf_status_t status =
      cf_setpoint_rpyt(&setpoint, &onboard->rpyt, priority, roll, pitch, yaw, thrust);
  const cf_provider_t *provider = cf_provider_of(cf);
  if (onboard->rpyt.is_holding_altitude && !was_hold && provider != NULL) {
    provider->reset_position_control(cf->provider_state, &onboard->estimate.position);
  }
  return send_if(cf, status, &setpoint);
}

cf_status_t cf_send_velocity_world(cf_t *cf, float vx, float vy, float vz, float yaw_rate) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_velocity_world(&setpoint, vx, vy, vz, yaw_rate), &setpoint);
}

cf_status_t cf_send_zdistance(cf_t *cf, float roll, float pitch, float yaw_rate, float z) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_zdistance(&setpoint, roll, pitch, yaw_rate, z), &setpoint);
}

cf_status_t cf_send_altitude_hold(cf_t *cf, float roll, float pitch, float yaw_rate, float vz) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_altitude_hold(&setpoint, roll, pitch, yaw_rate, vz), &setpoint);
}

cf_status_t cf_send_hover(cf_t *cf, float vx, float vy, float yaw_rate, float z) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_hover(&setpoint, vx, vy, yaw_rate, z), &setpoint);
}

cf_status_t cf_send_position(cf_t *cf, float x, float y, float z, float yaw) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_position(&setpoint, x, y, z, yaw), &setpoint);
}

cf_status_t cf_send_full_state(cf_t *cf, const cf_full_state_t *full_state) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_full_state(&setpoint, full_state), &setpoint);
}

cf_status_t cf_send_manual(cf_t *cf, float roll, float pitch, float yaw_rate, uint16_t thrust,
                           bool rate) {
  setpoint_t setpoint;
  return send_if(cf, cf_setpoint_manual(&setpoint, roll, pitch, yaw_rate, thrust, rate), &setpoint);
}

void cf_notify_setpoint_stop(cf_t *cf) {
  if (cf_system_of(cf) != NULL) {
    cf_system_request(cf, CF_SYSTEM_RELAX);
    return;
  }
  cf_commander_relax_priority(&cf->onboard.commander, &cf->onboard.high_level,
                              &cf->onboard.estimate);
}

// -------------------------------------------------------------------------- high-level commander

cf_status_t cf_takeoff(cf_t *cf, float height, float duration, float yaw, bool use_current_yaw) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_takeoff(cf, height, duration, yaw, use_current_yaw);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL
             ? CF_ERR_STATE
             : cf_high_level_commander_takeoff(HIGH_LEVEL(cf, provider), height, duration, yaw,
                                               use_current_yaw, now_us(cf));
}

cf_status_t cf_land(cf_t *cf, float height, float duration, float yaw, bool use_current_yaw) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_land(cf, height, duration, yaw, use_current_yaw);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE
                          : cf_high_level_commander_land(HIGH_LEVEL(cf, provider), height, duration,
                                                         yaw, use_current_yaw, now_us(cf));
}

cf_status_t cf_stop(cf_t *cf) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_stop(cf);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE : cf_high_level_commander_stop(HIGH_LEVEL(cf, provider));
}

cf_status_t cf_go_to(cf_t *cf, float x, float y, float z, float yaw, float duration, bool relative,
                     bool linear) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_go_to(cf, x, y, z, yaw, duration, relative, linear);
  }
  const struct vec     position = {x, y, z};
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE
                          : cf_high_level_commander_go_to(HIGH_LEVEL(cf, provider), position, yaw,
                                                          duration, relative, linear, now_us(cf));
}

cf_status_t cf_takeoff_with_velocity(cf_t *cf, float height, bool height_is_relative,
                                     float velocity, float yaw, bool use_current_yaw) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_takeoff_with_velocity(cf, height, height_is_relative, velocity, yaw,
                                           use_current_yaw);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE
                          : cf_high_level_commander_takeoff_with_velocity(
                                HIGH_LEVEL(cf, provider), height, height_is_relative, velocity, yaw,
                                use_current_yaw, now_us(cf));
}

cf_status_t cf_land_with_velocity(cf_t *cf, float height, bool height_is_relative, float velocity,
                                  float yaw, bool use_current_yaw) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_land_with_velocity(cf, height, height_is_relative, velocity, yaw,
                                        use_current_yaw);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE
                          : cf_high_level_commander_land_with_velocity(
                                HIGH_LEVEL(cf, provider), height, height_is_relative, velocity, yaw,
                                use_current_yaw, now_us(cf));
}

cf_status_t cf_spiral(cf_t *cf, const cf_spiral_t *spiral) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_spiral(cf, spiral);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL
             ? CF_ERR_STATE
             : cf_high_level_commander_spiral(HIGH_LEVEL(cf, provider), spiral, now_us(cf));
}

void cf_set_group_mask(cf_t *cf, uint8_t mask) {
  if (cf_system_of(cf) != NULL) {
    cf_system_set_group_mask(cf, mask);
    return;
  }
  cf_high_level_commander_set_group_mask(&cf->onboard.high_level, mask);
}

cf_status_t cf_write_trajectory(cf_t *cf, uint32_t offset, uint32_t length, const uint8_t *data) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_write_trajectory(cf, offset, length, data);
  }
  return cf_high_level_commander_write_trajectory(&cf->onboard.high_level, offset, length, data);
}

cf_status_t cf_read_trajectory(const cf_t *cf, uint32_t offset, uint32_t length, uint8_t *data) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_read_trajectory(cf, offset, length, data);
  }
  return cf_high_level_commander_read_trajectory(&cf->onboard.high_level, offset, length, data);
}

cf_status_t cf_define_trajectory(cf_t *cf, uint8_t id, uint8_t type, uint32_t offset,
                                 uint8_t n_pieces) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_define_trajectory(cf, id, type, offset, n_pieces);
  }
  return cf_high_level_commander_define_trajectory(&cf->onboard.high_level, id, type, offset,
                                                   n_pieces);
}

cf_status_t cf_start_trajectory(cf_t *cf, uint8_t id, float timescale, bool relative_position,
                                bool relative_yaw, bool reversed) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_start_trajectory(cf, id, timescale, relative_position, relative_yaw, reversed);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE
                          : cf_high_level_commander_start_trajectory(
                                HIGH_LEVEL(cf, provider), id, timescale, relative_position,
                                relative_yaw, reversed, now_us(cf));
}

bool cf_is_trajectory_finished(const cf_t *cf) {
  if (cf_system_of(cf) != NULL) {
    return cf->onboard.plan_is_finished;
  }
  const cf_provider_t *provider = cf_provider(cf->config.provider);
  const bool           works    = provider != NULL && cf->onboard.fault != CF_FAULT_SOFTWARE;
  return !works ||
         cf_high_level_commander_is_trajectory_finished(HIGH_LEVEL(cf, provider), now_us(cf));
}

int cf_high_level_packet(cf_t *cf, const uint8_t *data, uint32_t size,
                         uint8_t reply[CF_HIGH_LEVEL_REPLY_BYTES]) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_high_level_packet(cf, data, size, reply);
  }
  const cf_provider_t *provider = cf_provider_of(cf);
  return provider == NULL ? CF_ERR_STATE
                          : cf_high_level_commander_packet(HIGH_LEVEL(cf, provider), data, size,
                                                           now_us(cf), reply);
}

// ------------------------------------------------------------------- supervisor and localization

cf_status_t cf_arm(cf_t *cf, bool arm) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_request(cf, arm ? CF_SYSTEM_ARM : CF_SYSTEM_DISARM);
  }
  return cf_supervisor_request_arming(&cf->onboard.supervisor, arm) ? CF_OK : CF_ERR_STATE;
}

cf_status_t cf_recover_from_crash(cf_t *cf) {
  if (cf_system_of(cf) != NULL) {
    return cf_system_request(cf, CF_SYSTEM_RECOVER);
  }
  return cf_supervisor_request_crash_recovery(&cf->onboard.supervisor, true) ? CF_OK : CF_ERR_STATE;
}

void cf_emergency_stop(cf_t *cf) {
  if (cf_system_of(cf) != NULL) {
    cf_system_request(cf, CF_SYSTEM_EMERGENCY_STOP);
    return;
  }
  cf_supervisor_request_emergency_stop(&cf->onboard.supervisor);
}

void cf_feed_emergency_watchdog(cf_t *cf) {
  if (cf_system_of(cf) != NULL) {
    cf_system_request(cf, CF_SYSTEM_FEED_WATCHDOG);
    return;
  }
  cf_supervisor_notify_emergency_watchdog(&cf->onboard.supervisor, cf->onboard.tick);
}

void cf_fail_pilot(cf_t *cf, const char *reason) {
  cf_onboard_fail_pilot(&cf->onboard, reason);
}

cf_status_t cf_send_external_position(cf_t *cf, float x, float y, float z) {
  if (!isfinite(x + y + z)) {
    return CF_ERR_VALUE;
  }
  return cf_onboard_external_position(&cf->onboard, x, y, z) ? CF_OK : CF_ERR_CAPACITY;
}

cf_status_t cf_send_external_pose(cf_t *cf, float x, float y, float z, const float quat_xyzw[4]) {
  const float sum = (x + y + z) + (quat_xyzw[0] + quat_xyzw[1] + quat_xyzw[2] + quat_xyzw[3]);
  if (!isfinite(sum)) {
    return CF_ERR_VALUE;
  }
  const poseMeasurement_t pose = {
      .pos  = {x, y, z},
      .quat = {.x = quat_xyzw[0], .y = quat_xyzw[1], .z = quat_xyzw[2], .w = quat_xyzw[3]},
  };
  return cf_onboard_external_pose(&cf->onboard, &pose) ? CF_OK : CF_ERR_CAPACITY;
}

cf_status_t cf_send_peer_position(cf_t *cf, uint8_t id, float x, float y, float z) {
  if (id == 0 || !isfinite(x + y + z)) {
    return CF_ERR_VALUE;
  }
  const float position[3] = {x, y, z};
  const bool  is_taken =
      cf_peer_localization_tell(&cf->onboard.peers, id, position, cf->onboard.tick);
  return is_taken ? CF_OK : CF_ERR_CAPACITY;
}
