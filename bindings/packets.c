// CRTP packets of a client, dispatched to their modules (cf_receive_packet of commands.h).

#include <string.h>

#include "commands.h"
#include "onboard/packets/localization_packets.h"
#include "onboard/packets/setpoint_packets.h"
#include "onboard/packets/supervisor_packets.h"
#include "system_commands.h"

#define PORT_RPYT 3
#define PORT_LOCALIZATION 6
#define PORT_GENERIC 7
#define PORT_HIGH_LEVEL 8
#define PORT_SUPERVISOR 9

#define CHANNEL_SETPOINT 0
#define CHANNEL_META 1     // of port 7
#define CHANNEL_COMMAND 0  // of port 8

static cf_status_t receive_rpyt(cf_t *cf, uint8_t channel, const uint8_t *data, int length) {
  if (channel != CHANNEL_SETPOINT) {
    return CF_ERR_UNKNOWN;
  }
  cf_rpyt_packet_t  packet;
  const cf_status_t status = cf_rpyt_packet_decode(&packet, data, length);
  return status == CF_OK ? cf_send_rpyt(cf, packet.roll, packet.pitch, packet.yaw, packet.thrust)
                         : status;
}

static cf_status_t receive_generic(cf_t *cf, uint8_t channel, const uint8_t *data, int length) {
  cf_status_t status = CF_ERR_UNKNOWN;
  if (channel == CHANNEL_SETPOINT) {
    setpoint_t setpoint;
    status = cf_generic_packet_decode(&setpoint, &cf->onboard.cppm, data, length);
    return status == CF_OK ? cf_send_setpoint(cf, &setpoint) : status;
  }
  if (channel == CHANNEL_META) {
    status = cf_meta_packet_decode(data, length);
    if (status == CF_OK) {
      cf_notify_setpoint_stop(cf);
    }
  }
  return status;
}

static cf_status_t locate_myself(cf_t *cf, const cf_located_t *item) {
  const float *p = item->position;
  return item->has_attitude ? cf_send_external_pose(cf, p[0], p[1], p[2], item->quat_xyzw)
                            : cf_send_external_position(cf, p[0], p[1], p[2]);
}

// Returns the first refusal about this drone; the drone still receives the other items. Peers that
// do not fit into the table are dropped.
static cf_status_t locate(cf_t *cf, const cf_localization_packet_t *packet) {
  cf_status_t status = CF_OK;
  for (int i = 0; i < packet->n_items; i++) {
    const cf_located_t *item = &packet->items[i];
    if (item->id != cf->onboard.radio_id) {
      cf_send_peer_position(cf, item->id, item->position[0], item->position[1], item->position[2]);
      continue;
    }
    const cf_status_t told = locate_myself(cf, item);
    status                 = status == CF_OK ? told : status;
  }
  return status;
}

static cf_status_t receive_localization(cf_t *cf, uint8_t channel, const uint8_t *data, int length,
                                        cf_packet_reply_t *reply) {
  cf_localization_packet_t packet;
  const cf_status_t        status =
      cf_localization_packet_decode(&packet, cf->onboard.radio_id, channel, data, length);
  if (status != CF_OK) {
    return status;
  }

  if (packet.request == CF_LOCALIZATION_ASKS_TO_STOP) {
    cf_emergency_stop(cf);
  }
  if (packet.request == CF_LOCALIZATION_ASKS_TO_WATCH) {
    cf_feed_emergency_watchdog(cf);
  }
  reply->length = packet.reply_length;
  memcpy(reply->data, packet.reply, sizeof packet.reply);
  return locate(cf, &packet);
}

// The reply carries the error of a command.
static cf_status_t receive_high_level(cf_t *cf, uint8_t channel, const uint8_t *data, int length,
                                      cf_packet_reply_t *reply) {
  if (channel != CHANNEL_COMMAND) {
    return CF_ERR_UNKNOWN;
  }
  reply->length = cf_high_level_packet(cf, data, (uint32_t)length, reply->data);
  return CF_OK;
}

cf_status_t cf_receive_packet(cf_t *cf, uint8_t port, uint8_t channel, const uint8_t *data,
                              int length, cf_packet_reply_t *reply) {
  memset(reply, 0, sizeof *reply);
  if (length < 0 || length > CF_PACKET_BYTES) {
    return CF_ERR_VALUE;
  }

  if (port != PORT_LOCALIZATION && cf_system_of(cf) != NULL &&
      cf_system_packet(cf, port, channel, data, length, reply)) {
    return CF_OK;
  }
  switch (port) {
    case PORT_RPYT:
      return receive_rpyt(cf, channel, data, length);
    case PORT_LOCALIZATION:
      return receive_localization(cf, channel, data, length, reply);
    case PORT_GENERIC:
      return receive_generic(cf, channel, data, length);
    case PORT_HIGH_LEVEL:
      return receive_high_level(cf, channel, data, length, reply);
    case PORT_SUPERVISOR:
      return cf_supervisor_packet(&cf->onboard.supervisor, cf->onboard.tick, channel, data, length,
                                  reply);
    default:
      return CF_ERR_UNKNOWN;
  }
}
