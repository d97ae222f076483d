#include "system_commands.h"

#include <math.h>
#include <string.h>

#include "little_endian.h"

#define PORT_HIGH_LEVEL 8

// Commands of port 8 and the group of every vehicle (docs/reference/planner-commander.md#7.2).
#define SET_GROUP_MASK 0
#define STOP 3
#define GO_TO 4
#define START_TRAJECTORY 5
#define DEFINE_TRAJECTORY 6
#define TAKEOFF_2 7
#define LAND_2 8
#define TAKEOFF_WITH_VELOCITY 9
#define LAND_WITH_VELOCITY 10
#define SPIRAL 11
#define GO_TO_2 12
#define START_TRAJECTORY_2 13
#define ALL_GROUPS 0
#define GO_TO_2_HEAD 4  // [bytes] in front of its numbers

#define REPLY_CODE 3  // place in a reply

const cf_system_t *cf_system_of(const cf_t *cf) {
  const cf_provider_t *provider = cf_provider(cf->config.provider);
  const bool           works    = provider != NULL && cf->onboard.fault != CF_FAULT_SOFTWARE;
  return works ? provider->system : NULL;
}

// ------------------------------------------------------------------------- setpoints and requests

cf_status_t cf_system_set_setpoint(cf_t *cf, const cf_system_t *system,
                                   const setpoint_t *setpoint) {
  const bool is_taken =
      system->set_setpoint(cf->provider_state, setpoint, COMMANDER_PRIORITY_CRTP, cf->onboard.tick);
  if (is_taken) {
    cf->onboard.commander.priority = COMMANDER_PRIORITY_CRTP;
  }
  return is_taken ? CF_OK : CF_ERR_STATE;
}

cf_status_t cf_system_request(cf_t *cf, cf_system_request_t what) {
  const cf_system_t *system = cf_system_of(cf);
  const bool         is_done =
      system != NULL && system->request(cf->provider_state, what, cf->onboard.tick);
  if (is_done && what == CF_SYSTEM_RELAX) {
    cf->onboard.commander.priority = COMMANDER_PRIORITY_LOWEST;
  }
  return is_done ? CF_OK : CF_ERR_STATE;
}

// ---------------------------------------------------------------------------------------- packets

// What is defined is known here as well, so that a trajectory that is not can be refused.
static void note_definition(cf_t *cf, const uint8_t *data, int length) {
  if (length >= 9 && data[0] == DEFINE_TRAJECTORY) {
    cf_high_level_commander_define_trajectory(&cf->onboard.high_level, data[1], data[3],
                                              cf_le_u32(&data[4]), data[8]);
  }
}

bool cf_system_packet(cf_t *cf, uint8_t port, uint8_t channel, const uint8_t *data, int length,
                      cf_packet_reply_t *reply) {
  const cf_system_t *system = cf_system_of(cf);
  if (system == NULL) {
    return false;
  }
  const int answered = system->packet(cf->provider_state, port, channel, data, length, reply->data,
                                      cf->onboard.tick);
  reply->length      = answered > 0 ? answered : 0;
  if (answered > 0 && port == PORT_HIGH_LEVEL) {
    note_definition(cf, data, length);
  }
  return answered >= 0;
}

int cf_system_high_level_packet(cf_t *cf, const uint8_t *data, uint32_t size,
                                uint8_t reply[CF_HIGH_LEVEL_REPLY_BYTES]) {
  cf_packet_reply_t full;
  if (size == 0 || size > CF_PACKET_BYTES ||
      !cf_system_packet(cf, PORT_HIGH_LEVEL, 0, data, (int)size, &full)) {
    return 0;
  }
  const int length =
      full.length < CF_HIGH_LEVEL_REPLY_BYTES ? full.length : CF_HIGH_LEVEL_REPLY_BYTES;
  memcpy(reply, full.data, (size_t)length);
  return length;
}

// A record in the making.
typedef struct {
  uint8_t  bytes[CF_PACKET_BYTES];
  uint32_t size;
} record_t;

static void put_byte(record_t *record, uint8_t value) {
  record->bytes[record->size++] = value;
}

static void put_float(record_t *record, float value) {
  cf_put_le_float(&record->bytes[record->size], value);
  record->size += 4;
}

static record_t begin(uint8_t command) {
  record_t record = {.size = 0};
  put_byte(&record, command);
  return record;
}

static record_t begin_for_all(uint8_t command) {
  record_t record = begin(command);
  put_byte(&record, ALL_GROUPS);
  return record;
}

// Returns the code of the reply, or -1 without one.
static int ask(cf_t *cf, const record_t *record) {
  uint8_t   reply[CF_HIGH_LEVEL_REPLY_BYTES] = {0};
  const int length = cf_system_high_level_packet(cf, record->bytes, record->size, reply);
  return length > REPLY_CODE ? reply[REPLY_CODE] : -1;
}

static cf_status_t status_of(int code) {
  switch (code) {
    case CF_HIGH_LEVEL_REPLY_OK:
      return CF_OK;
    case CF_HIGH_LEVEL_REPLY_BUSY:
      return CF_ERR_BLOCKED;
    case CF_HIGH_LEVEL_REPLY_NOEXEC:
      return CF_ERR_VALUE;
    default:
      return CF_ERR_STATE;
  }
}

static cf_status_t send(cf_t *cf, const record_t *record) {
  return status_of(ask(cf, record));
}

// Firmware that does not know the newest form of a command gets the older one, which says less;
// what is lost then, if anything is, goes to the console.
static cf_status_t send_either(cf_t *cf, const record_t *newest, const record_t *older,
                               const char *lost) {
  const int code = ask(cf, newest);
  if (code != CF_HIGH_LEVEL_REPLY_NOEXEC) {
    return status_of(code);
  }
  const cf_status_t status = send(cf, older);
  if (status == CF_OK && lost != NULL) {
    cf_console_print_line(&cf->onboard.console, "HLCOMMANDER: this firmware knows no ", lost, NULL);
  }
  return status;
}

// --------------------------------------------------------------------------------------- commands

static bool is_positive(float value) {
  return isfinite(value) && value > 0.0f;
}

static cf_status_t move_vertically(cf_t *cf, uint8_t command, float height, float duration,
                                   float yaw, bool use_current_yaw) {
  if (!isfinite(height) || !is_positive(duration) || (!use_current_yaw && !isfinite(yaw))) {
    return CF_ERR_VALUE;
  }
  record_t record = begin_for_all(command);
  put_float(&record, height);
  put_float(&record, use_current_yaw ? 0.0f : yaw);
  put_byte(&record, use_current_yaw);
  put_float(&record, duration);
  return send(cf, &record);
}

cf_status_t cf_system_takeoff(cf_t *cf, float height, float duration, float yaw,
                              bool use_current_yaw) {
  return move_vertically(cf, TAKEOFF_2, height, duration, yaw, use_current_yaw);
}

cf_status_t cf_system_land(cf_t *cf, float height, float duration, float yaw,
                           bool use_current_yaw) {
  return move_vertically(cf, LAND_2, height, duration, yaw, use_current_yaw);
}

static cf_status_t move_at_velocity(cf_t *cf, uint8_t command, float height,
                                    bool height_is_relative, float velocity, float yaw,
                                    bool use_current_yaw) {
  if (!isfinite(height + velocity) || (!use_current_yaw && !isfinite(yaw))) {
    return CF_ERR_VALUE;
  }
  record_t record = begin_for_all(command);
  put_float(&record, height);
  put_byte(&record, height_is_relative);
  put_float(&record, use_current_yaw ? 0.0f : yaw);
  put_byte(&record, use_current_yaw);
  put_float(&record, velocity);
  return send(cf, &record);
}

cf_status_t cf_system_takeoff_with_velocity(cf_t *cf, float height, bool height_is_relative,
                                            float velocity, float yaw, bool use_current_yaw) {
  return move_at_velocity(cf, TAKEOFF_WITH_VELOCITY, height, height_is_relative, velocity, yaw,
                          use_current_yaw);
}

cf_status_t cf_system_land_with_velocity(cf_t *cf, float height, bool height_is_relative,
                                         float velocity, float yaw, bool use_current_yaw) {
  return move_at_velocity(cf, LAND_WITH_VELOCITY, height, height_is_relative, velocity, yaw,
                          use_current_yaw);
}

cf_status_t cf_system_stop(cf_t *cf) {
  const record_t record = begin_for_all(STOP);
  return send(cf, &record);
}

cf_status_t cf_system_go_to(cf_t *cf, float x, float y, float z, float yaw, float duration,
                            bool relative, bool linear) {
  if (!isfinite(x + y + z + yaw) || !is_positive(duration)) {
    return CF_ERR_VALUE;
  }
  record_t newest = begin_for_all(GO_TO_2);
  record_t older  = begin_for_all(GO_TO);
  put_byte(&newest, relative);
  put_byte(&older, relative);
  put_byte(&newest, linear);
  const float numbers[] = {x, y, z, yaw, duration};
  for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
    put_float(&newest, numbers[i]);
    put_float(&older, numbers[i]);
  }
  return send_either(cf, &newest, &older, linear ? "linear go-to, it flies a smooth one" : NULL);
}

cf_status_t cf_system_spiral(cf_t *cf, const cf_spiral_t *spiral) {
  if (!isfinite(spiral->angle + spiral->radius0 + spiral->radiusF + spiral->ascent) ||
      !is_positive(spiral->duration)) {
    return CF_ERR_VALUE;
  }
  record_t record = begin_for_all(SPIRAL);
  put_byte(&record, spiral->sideways);
  put_byte(&record, spiral->clockwise);
  put_float(&record, spiral->angle);
  put_float(&record, spiral->radius0);
  put_float(&record, spiral->radiusF);
  put_float(&record, spiral->ascent);
  put_float(&record, spiral->duration);
  return send(cf, &record);
}

void cf_system_set_group_mask(cf_t *cf, uint8_t mask) {
  record_t record = begin(SET_GROUP_MASK);
  put_byte(&record, mask);
  if (send(cf, &record) == CF_OK) {
    cf_high_level_commander_set_group_mask(&cf->onboard.high_level, mask);
  }
}

// ----------------------------------------------------------------------------------- trajectories

cf_status_t cf_system_define_trajectory(cf_t *cf, uint8_t id, uint8_t type, uint32_t offset,
                                        uint8_t n_pieces) {
  const cf_status_t status = cf_high_level_commander_define_trajectory(&cf->onboard.high_level, id,
                                                                       type, offset, n_pieces);
  if (status != CF_OK) {
    return status;
  }
  record_t record = begin(DEFINE_TRAJECTORY);
  put_byte(&record, id);
  put_byte(&record, CF_TRAJECTORY_LOCATION_MEMORY);
  put_byte(&record, type);
  cf_put_le_u32(&record.bytes[record.size], offset);
  record.size += 4;
  put_byte(&record, n_pieces);
  return send(cf, &record);
}

cf_status_t cf_system_start_trajectory(cf_t *cf, uint8_t id, float timescale,
                                       bool relative_position, bool relative_yaw, bool reversed) {
  if (!is_positive(timescale)) {
    return CF_ERR_VALUE;
  }
  if (!cf_high_level_commander_is_trajectory_defined(&cf->onboard.high_level, id)) {
    return CF_ERR_UNKNOWN;
  }
  record_t newest = begin_for_all(START_TRAJECTORY_2);
  record_t older  = begin_for_all(START_TRAJECTORY);
  put_byte(&newest, relative_position);
  put_byte(&older, relative_position);
  put_byte(&newest, relative_yaw);
  put_byte(&newest, reversed);
  put_byte(&older, reversed);
  put_byte(&newest, id);
  put_byte(&older, id);
  put_float(&newest, timescale);
  put_float(&older, timescale);
  return send_either(cf, &newest, &older,
                     relative_yaw ? "trajectories relative to the yaw, it keeps theirs" : NULL);
}

cf_status_t cf_system_write_trajectory(cf_t *cf, uint32_t offset, uint32_t length,
                                       const uint8_t *data) {
  const cf_system_t *system = cf_system_of(cf);
  const cf_status_t  status =
      cf_high_level_commander_write_trajectory(&cf->onboard.high_level, offset, length, data);
  if (status != CF_OK || length == 0) {
    return status;
  }
  return system != NULL && system->write_trajectory(cf->provider_state, offset, length, data)
             ? CF_OK
             : CF_ERR_STATE;
}

cf_status_t cf_system_read_trajectory(const cf_t *cf, uint32_t offset, uint32_t length,
                                      uint8_t *data) {
  return cf_high_level_commander_read_trajectory(&cf->onboard.high_level, offset, length, data);
}
