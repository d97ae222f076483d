#include "onboard/packets/supervisor_packets.h"

#include "onboard/packets/packet_reader.h"

#define ANSWER 0x80  // added to the number that is answered

static void put(cf_packet_reply_t *reply, unsigned byte) {
  reply->data[reply->length++] = (uint8_t)byte;
}

// States that can change between two updates of the supervisor are reported as of now, the others
// as of the last update.
static bool answer(const cf_supervisor_t *supervisor, uint8_t query) {
  switch (query) {
    case CF_SUPERVISOR_QUERY_IS_ARMED:
      return cf_supervisor_is_armed(supervisor);
    case CF_SUPERVISOR_QUERY_IS_CRASHED:
      return cf_supervisor_is_crashed(supervisor);
    default:
      return (supervisor->info >> (query - 1) & 1) != 0;
  }
}

static cf_status_t answer_query(const cf_supervisor_t *supervisor, cf_packet_reader_t *reader,
                                cf_packet_reply_t *reply) {
  const uint8_t query = cf_read_u8(reader);
  if (!cf_packet_is_read(reader)) {
    return CF_ERR_VALUE;
  }
  if (query < CF_SUPERVISOR_QUERY_CAN_ARM || query > CF_SUPERVISOR_QUERY_BITFIELD) {
    return CF_ERR_UNKNOWN;
  }

  put(reply, query | ANSWER);
  if (query == CF_SUPERVISOR_QUERY_BITFIELD) {
    put(reply, supervisor->info & 0xFF);
    put(reply, supervisor->info >> 8);
  } else {
    put(reply, answer(supervisor, query));
  }
  return CF_OK;
}

static void obey(cf_supervisor_t *supervisor, uint32_t now, uint8_t command, bool argument,
                 cf_packet_reply_t *reply) {
  switch (command) {
    case CF_SUPERVISOR_COMMAND_ARM:
      put(reply, CF_SUPERVISOR_COMMAND_ARM | ANSWER);
      put(reply, cf_supervisor_request_arming(supervisor, argument));
      put(reply, cf_supervisor_is_armed(supervisor));
      break;
    case CF_SUPERVISOR_COMMAND_RECOVER:
      put(reply, CF_SUPERVISOR_COMMAND_RECOVER | ANSWER);
      put(reply, cf_supervisor_request_crash_recovery(supervisor, true));
      put(reply, !cf_supervisor_is_crashed(supervisor));
      break;
    case CF_SUPERVISOR_COMMAND_EMERGENCY_STOP:
      cf_supervisor_request_emergency_stop(supervisor);
      break;
    default:
      cf_supervisor_notify_emergency_watchdog(supervisor, now);
      break;
  }
}

static cf_status_t obey_command(cf_supervisor_t *supervisor, uint32_t now,
                                cf_packet_reader_t *reader, cf_packet_reply_t *reply) {
  const uint8_t command  = cf_read_u8(reader);
  const bool    argument = command == CF_SUPERVISOR_COMMAND_ARM && cf_read_u8(reader) != 0;
  if (command < CF_SUPERVISOR_COMMAND_ARM || command > CF_SUPERVISOR_COMMAND_EMERGENCY_WATCHDOG) {
    return reader->is_short ? CF_ERR_VALUE : CF_ERR_UNKNOWN;
  }
  if (!cf_packet_is_read(reader)) {
    return CF_ERR_VALUE;
  }
  obey(supervisor, now, command, argument, reply);
  return CF_OK;
}

cf_status_t cf_supervisor_packet(cf_supervisor_t *supervisor, uint32_t now, uint8_t channel,
                                 const uint8_t *data, int length, cf_packet_reply_t *reply) {
  cf_packet_reader_t reader = cf_packet_reader(data, length);
  reply->length             = 0;
  if (channel == CF_SUPERVISOR_CHANNEL_INFO) {
    return answer_query(supervisor, &reader, reply);
  }
  if (channel == CF_SUPERVISOR_CHANNEL_COMMAND) {
    return obey_command(supervisor, now, &reader, reply);
  }
  return CF_ERR_UNKNOWN;
}
