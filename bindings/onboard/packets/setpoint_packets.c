#include "onboard/packets/setpoint_packets.h"

#include "api/math3d.h"
#include "api/quatcompress.h"
#include "onboard/commander/setpoints.h"
#include "onboard/packets/packet_reader.h"

#define CPPM_AUX_COUNT 0x0F  // of the first byte; the high half is reserved

// degrees per milliradian, rounded as in the firmware
#define DEGREES_PER_MILLIRADIAN (180.0f / (M_PI_F * 1000.0f))

// The builders of setpoints.h for four numbers have one form.
typedef cf_status_t build_t(setpoint_t *setpoint, float a, float b, float c, float d);

static cf_status_t decode_floats(setpoint_t *setpoint, build_t *build, cf_packet_reader_t *reader) {
  float v[4];
  cf_read_floats(reader, v, 4);
  return build(setpoint, v[0], v[1], v[2], v[3]);
}

static cf_status_t decode_legacy(setpoint_t *setpoint, build_t *build, cf_packet_reader_t *reader) {
  const cf_status_t status   = decode_floats(setpoint, build, reader);
  setpoint->attitudeRate.yaw = -setpoint->attitudeRate.yaw;
  return status;
}

static cf_status_t decode_cppm(setpoint_t *setpoint, const cf_cppm_t *cppm,
                               cf_packet_reader_t *reader) {
  cf_cppm_sticks_t sticks = {.n_aux = cf_read_u8(reader) & CPPM_AUX_COUNT};
  sticks.roll             = cf_read_u16(reader);
  sticks.pitch            = cf_read_u16(reader);
  sticks.yaw              = cf_read_u16(reader);
  sticks.thrust           = cf_read_u16(reader);
  if (sticks.n_aux > CF_CPPM_MAX_AUX) {
    return CF_ERR_VALUE;
  }
  for (int i = 0; i < sticks.n_aux; i++) {
    sticks.aux[i] = cf_read_u16(reader);
  }
  return cf_setpoint_cppm(setpoint, cppm, &sticks);
}

// A compressed attitude that no rotation has becomes NaN, and is refused with the rest.
static cf_status_t decode_full_state(setpoint_t *setpoint, cf_packet_reader_t *reader) {
  float lengths[9], quat[4], rates[3];
  cf_read_thousandths(reader, lengths, 9);
  quatdecompress(cf_read_u32(reader), quat);
  for (int i = 0; i < 3; i++) {
    rates[i] = DEGREES_PER_MILLIRADIAN * (float)cf_read_i16(reader);
  }

  const cf_full_state_t full_state = {
      .position     = {.x = lengths[0], .y = lengths[1], .z = lengths[2]},
      .velocity     = {.x = lengths[3], .y = lengths[4], .z = lengths[5]},
      .acceleration = {.x = lengths[6], .y = lengths[7], .z = lengths[8]},
      .attitude     = {.x = quat[0], .y = quat[1], .z = quat[2], .w = quat[3]},
  };
  const cf_status_t status     = cf_setpoint_full_state(setpoint, &full_state);
  setpoint->attitudeRate.roll  = rates[0];
  setpoint->attitudeRate.pitch = rates[1];
  setpoint->attitudeRate.yaw   = rates[2];
  return status;
}

static cf_status_t decode_manual(setpoint_t *setpoint, cf_packet_reader_t *reader) {
  float v[3];
  cf_read_floats(reader, v, 3);
  const uint16_t thrust  = cf_read_u16(reader);
  const bool     is_rate = cf_read_u8(reader) == 1;
  return cf_setpoint_manual(setpoint, v[0], v[1], v[2], thrust, is_rate);
}

static cf_status_t decode_type(setpoint_t *setpoint, uint8_t type, const cf_cppm_t *cppm,
                               cf_packet_reader_t *reader) {
  switch (type) {
    case CF_GENERIC_LEGACY_VELOCITY_WORLD:
      return decode_legacy(setpoint, cf_setpoint_velocity_world, reader);
    case CF_GENERIC_LEGACY_ZDISTANCE:
      return decode_legacy(setpoint, cf_setpoint_zdistance, reader);
    case CF_GENERIC_CPPM:
      return decode_cppm(setpoint, cppm, reader);
    case CF_GENERIC_ALTITUDE_HOLD:
      return decode_floats(setpoint, cf_setpoint_altitude_hold, reader);
    case CF_GENERIC_LEGACY_HOVER:
      return decode_legacy(setpoint, cf_setpoint_hover, reader);
    case CF_GENERIC_FULL_STATE:
      return decode_full_state(setpoint, reader);
    case CF_GENERIC_POSITION:
      return decode_floats(setpoint, cf_setpoint_position, reader);
    case CF_GENERIC_VELOCITY_WORLD:
      return decode_floats(setpoint, cf_setpoint_velocity_world, reader);
    case CF_GENERIC_ZDISTANCE:
      return decode_floats(setpoint, cf_setpoint_zdistance, reader);
    case CF_GENERIC_HOVER:
      return decode_floats(setpoint, cf_setpoint_hover, reader);
    case CF_GENERIC_MANUAL:
      return decode_manual(setpoint, reader);
    case CF_GENERIC_STOP:
      return CF_OK;
    default:
      // of unknown length
      reader->at = reader->length;
      return CF_OK;
  }
}

cf_status_t cf_generic_packet_decode(setpoint_t *setpoint, const cf_cppm_t *cppm,
                                     const uint8_t *data, int length) {
  cf_packet_reader_t reader = cf_packet_reader(data, length);
  const uint8_t      type   = cf_read_u8(&reader);

  setpoint_t wanted;
  cf_setpoint_stop(&wanted);
  const cf_status_t status = decode_type(&wanted, type, cppm, &reader);
  if (!cf_packet_is_read(&reader)) {
    return CF_ERR_VALUE;
  }
  if (status == CF_OK) {
    *setpoint = wanted;
  }
  return status;
}

cf_status_t cf_meta_packet_decode(const uint8_t *data, int length) {
  cf_packet_reader_t reader = cf_packet_reader(data, length);
  const uint8_t      type   = cf_read_u8(&reader);
  if (type != CF_META_NOTIFY_SETPOINTS_STOP) {
    return CF_ERR_UNKNOWN;
  }
  (void)cf_read_u32(
      &reader);  // how long setpoints remain valid [ms]: unused by the firmware as well
  return cf_packet_is_read(&reader) ? CF_OK : CF_ERR_VALUE;
}

cf_status_t cf_rpyt_packet_decode(cf_rpyt_packet_t *packet, const uint8_t *data, int length) {
  cf_packet_reader_t reader = cf_packet_reader(data, length);
  float              v[3];
  cf_read_floats(&reader, v, 3);
  const uint16_t thrust = cf_read_u16(&reader);
  if (!cf_packet_is_read(&reader) || !isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2])) {
    return CF_ERR_VALUE;
  }
  *packet = (cf_rpyt_packet_t){.roll = v[0], .pitch = v[1], .yaw = v[2], .thrust = thrust};
  return CF_OK;
}
