#include "onboard/packets/high_level_packets.h"

#include <stdbool.h>

#include "little_endian.h"

// --------------------------------------------------------------------------------------- numbers

static bool read_bool(const uint8_t *byte) {
  return *byte != 0;
}

// -------------------------------------------------------------------------------------- commands

// Whom a packet commands, and when.
typedef struct {
  cf_high_level_commander_t *commander;
  const cf_provider_t       *provider;
  void                      *provider_state;
  uint64_t                   now_us;
} target_t;

#define HIGH_LEVEL(target_) (target_)->commander, (target_)->provider, (target_)->provider_state

// Records are passed without the command byte; where a command has a group, it is byte 0.

static cf_status_t set_group_mask(const target_t *target, const uint8_t *record) {
  cf_high_level_commander_set_group_mask(target->commander, record[0]);
  return CF_OK;
}

// The first versions of take-off and landing turn to yaw 0.
static cf_status_t takeoff(const target_t *target, const uint8_t *record) {
  const float height   = cf_le_float(&record[1]);
  const float duration = cf_le_float(&record[5]);
  return cf_high_level_commander_takeoff(HIGH_LEVEL(target), height, duration, 0.0f, false,
                                         target->now_us);
}

static cf_status_t land(const target_t *target, const uint8_t *record) {
  const float height   = cf_le_float(&record[1]);
  const float duration = cf_le_float(&record[5]);
  return cf_high_level_commander_land(HIGH_LEVEL(target), height, duration, 0.0f, false,
                                      target->now_us);
}

static cf_status_t stop(const target_t *target, const uint8_t *record) {
  (void)record;
  return cf_high_level_commander_stop(HIGH_LEVEL(target));
}

static cf_status_t fly_to(const target_t *target, const uint8_t *numbers, bool relative,
                          bool linear) {
  const struct vec position = {cf_le_float(&numbers[0]), cf_le_float(&numbers[4]),
                               cf_le_float(&numbers[8])};
  const float      yaw      = cf_le_float(&numbers[12]);
  const float      duration = cf_le_float(&numbers[16]);
  return cf_high_level_commander_go_to(HIGH_LEVEL(target), position, yaw, duration, relative,
                                       linear, target->now_us);
}

static cf_status_t go_to(const target_t *target, const uint8_t *record) {
  return fly_to(target, &record[2], read_bool(&record[1]), false);
}

static cf_status_t go_to_2(const target_t *target, const uint8_t *record) {
  return fly_to(target, &record[3], read_bool(&record[1]), read_bool(&record[2]));
}

// The firmware answers 0 when nothing is defined under the number.
static cf_status_t start(const target_t *target, uint8_t id, float timescale,
                         bool relative_position, bool relative_yaw, bool reversed) {
  const cf_status_t status = cf_high_level_commander_start_trajectory(
      HIGH_LEVEL(target), id, timescale, relative_position, relative_yaw, reversed, target->now_us);
  return status == CF_ERR_UNKNOWN ? CF_OK : status;
}

static cf_status_t start_trajectory(const target_t *target, const uint8_t *record) {
  return start(target, record[3], cf_le_float(&record[4]), read_bool(&record[1]), false,
               read_bool(&record[2]));
}

static cf_status_t start_trajectory_2(const target_t *target, const uint8_t *record) {
  return start(target, record[4], cf_le_float(&record[5]), read_bool(&record[1]),
               read_bool(&record[2]), read_bool(&record[3]));
}

static cf_status_t define_trajectory(const target_t *target, const uint8_t *record) {
  const uint8_t location = record[1];
  if (location != CF_TRAJECTORY_LOCATION_MEMORY) {
    return CF_ERR_UNKNOWN;
  }
  return cf_high_level_commander_define_trajectory(target->commander, record[0], record[2],
                                                   cf_le_u32(&record[3]), record[7]);
}

static cf_status_t takeoff_2(const target_t *target, const uint8_t *record) {
  const float height   = cf_le_float(&record[1]);
  const float yaw      = cf_le_float(&record[5]);
  const float duration = cf_le_float(&record[10]);
  return cf_high_level_commander_takeoff(HIGH_LEVEL(target), height, duration, yaw,
                                         read_bool(&record[9]), target->now_us);
}

static cf_status_t land_2(const target_t *target, const uint8_t *record) {
  const float height   = cf_le_float(&record[1]);
  const float yaw      = cf_le_float(&record[5]);
  const float duration = cf_le_float(&record[10]);
  return cf_high_level_commander_land(HIGH_LEVEL(target), height, duration, yaw,
                                      read_bool(&record[9]), target->now_us);
}

static cf_status_t takeoff_with_velocity(const target_t *target, const uint8_t *record) {
  const float height   = cf_le_float(&record[1]);
  const float yaw      = cf_le_float(&record[6]);
  const float velocity = cf_le_float(&record[11]);
  return cf_high_level_commander_takeoff_with_velocity(HIGH_LEVEL(target), height,
                                                       read_bool(&record[5]), velocity, yaw,
                                                       read_bool(&record[10]), target->now_us);
}

static cf_status_t land_with_velocity(const target_t *target, const uint8_t *record) {
  const float height   = cf_le_float(&record[1]);
  const float yaw      = cf_le_float(&record[6]);
  const float velocity = cf_le_float(&record[11]);
  return cf_high_level_commander_land_with_velocity(HIGH_LEVEL(target), height,
                                                    read_bool(&record[5]), velocity, yaw,
                                                    read_bool(&record[10]), target->now_us);
}

static cf_status_t spiral(const target_t *target, const uint8_t *record) {
  const cf_spiral_t wanted = {
      .sideways  = read_bool(&record[1]),
      .clockwise = read_bool(&record[2]),
      .angle     = cf_le_float(&record[3]),
      .radius0   = cf_le_float(&record[7]),
      .radiusF   = cf_le_float(&record[11]),
      .ascent    = cf_le_float(&record[15]),
      .duration  = cf_le_float(&record[19]),
  };
  return cf_high_level_commander_spiral(HIGH_LEVEL(target), &wanted, target->now_us);
}

// -------------------------------------------------------------------------------------- dispatch

typedef struct {
  cf_status_t (*carry_out)(const target_t *target, const uint8_t *record);
  uint8_t bytes;      // of the record
  bool    has_group;  // byte 0 says which vehicles are meant
} command_t;

// by command byte
static const command_t COMMANDS[] = {
    {set_group_mask, 1, false},         // 0
    {takeoff, 9, true},                 // 1, deprecated
    {land, 9, true},                    // 2, deprecated
    {stop, 1, true},                    // 3
    {go_to, 22, true},                  // 4, deprecated
    {start_trajectory, 8, true},        // 5, deprecated
    {define_trajectory, 8, false},      // 6
    {takeoff_2, 14, true},              // 7
    {land_2, 14, true},                 // 8
    {takeoff_with_velocity, 15, true},  // 9
    {land_with_velocity, 15, true},     // 10
    {spiral, 23, true},                 // 11
    {go_to_2, 23, true},                // 12
    {start_trajectory_2, 9, true},      // 13
};

static cf_status_t dispatch(const target_t *target, const uint8_t *data, uint32_t size) {
  if (data[0] >= sizeof COMMANDS / sizeof COMMANDS[0]) {
    return CF_ERR_UNKNOWN;
  }
  const command_t *command = &COMMANDS[data[0]];
  if (size - 1 < command->bytes) {
    return CF_ERR_CAPACITY;
  }
  const uint8_t *record = &data[1];
  if (command->has_group && !cf_high_level_commander_is_in_group(target->commander, record[0])) {
    return CF_OK;
  }
  return command->carry_out(target, record);
}

static cf_high_level_reply_t reply_code(cf_status_t status) {
  switch (status) {
    case CF_OK:
      return CF_HIGH_LEVEL_REPLY_OK;
    case CF_ERR_STATE:
      return CF_HIGH_LEVEL_REPLY_REFUSED;
    case CF_ERR_BLOCKED:
      return CF_HIGH_LEVEL_REPLY_BUSY;
    case CF_ERR_VALUE:
    case CF_ERR_UNKNOWN:
    case CF_ERR_CAPACITY:
      break;
  }
  return CF_HIGH_LEVEL_REPLY_NOEXEC;
}

int cf_high_level_commander_packet(cf_high_level_commander_t *commander,
                                   const cf_provider_t *provider, void *provider_state,
                                   const uint8_t *data, uint32_t size, uint64_t now_us,
                                   uint8_t reply[CF_HIGH_LEVEL_REPLY_BYTES]) {
  if (size == 0) {
    return 0;
  }
  const target_t target = {
      .commander      = commander,
      .provider       = provider,
      .provider_state = provider_state,
      .now_us         = now_us,
  };
  reply[0] = data[0];
  reply[1] = size > 1 ? data[1] : 0;
  reply[2] = size > 2 ? data[2] : 0;
  reply[3] = (uint8_t)reply_code(dispatch(&target, data, size));
  return CF_HIGH_LEVEL_REPLY_BYTES;
}
