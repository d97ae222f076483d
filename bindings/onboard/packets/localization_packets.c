#include "onboard/packets/localization_packets.h"

#include <math.h>

#include "api/quatcompress.h"
#include "onboard/packets/packet_reader.h"

static void read_position(cf_localization_packet_t *packet, uint8_t own_id,
                          cf_packet_reader_t *reader) {
  cf_located_t *item = &packet->items[packet->n_items++];
  item->id           = own_id;
  cf_read_floats(reader, item->position, 3);
}

static void read_pose(cf_localization_packet_t *packet, uint8_t own_id,
                      cf_packet_reader_t *reader) {
  cf_located_t *item = &packet->items[packet->n_items++];
  item->id           = own_id;
  item->has_attitude = true;
  cf_read_floats(reader, item->position, 3);
  cf_read_floats(reader, item->quat_xyzw, 4);
}

// As many vehicles as the packet has room for; at least one.
static void read_packed(cf_localization_packet_t *packet, bool has_attitude,
                        cf_packet_reader_t *reader) {
  do {
    cf_located_t *item = &packet->items[packet->n_items++];
    item->id           = cf_read_u8(reader);
    item->has_attitude = has_attitude;
    cf_read_thousandths(reader, item->position, 3);
    if (has_attitude) {
      quatdecompress(cf_read_u32(reader), item->quat_xyzw);
    }
  } while (reader->at < reader->length && packet->n_items < CF_PACKET_MAX_LOCATED);
}

static void answer_no(cf_localization_packet_t *packet, uint8_t type) {
  packet->request                       = CF_LOCALIZATION_ASKS_FOR_AN_ANSWER;
  packet->reply[packet->reply_length++] = type;
}

static cf_status_t decode_generic(cf_localization_packet_t *packet, uint8_t own_id,
                                  cf_packet_reader_t *reader) {
  const uint8_t type = cf_read_u8(reader);
  switch (type) {
    case CF_LOCALIZATION_LPS_SHORT:
      answer_no(packet, type);
      packet->reply[packet->reply_length++] = cf_read_u8(reader);  // the destination
      packet->reply[packet->reply_length++] = 0;
      reader->at                            = reader->length;
      return CF_OK;
    case CF_LOCALIZATION_EMERGENCY_STOP:
      packet->request = CF_LOCALIZATION_ASKS_TO_STOP;
      return CF_OK;
    case CF_LOCALIZATION_EMERGENCY_WATCHDOG:
      packet->request = CF_LOCALIZATION_ASKS_TO_WATCH;
      return CF_OK;
    case CF_LOCALIZATION_POSE:
      read_pose(packet, own_id, reader);
      return CF_OK;
    case CF_LOCALIZATION_PACKED_POSES:
      read_packed(packet, true, reader);
      return CF_OK;
    case CF_LOCALIZATION_LIGHTHOUSE_PERSIST:
      answer_no(packet, type);
      packet->reply[packet->reply_length++] = 0;
      (void)cf_read_u16(reader);  // geometries
      (void)cf_read_u16(reader);  // calibrations
      return CF_OK;
    default:
      return reader->is_short ? CF_ERR_VALUE : CF_ERR_UNKNOWN;
  }
}

static bool are_items_finite(const cf_localization_packet_t *packet) {
  for (int i = 0; i < packet->n_items; i++) {
    const float *p = packet->items[i].position;
    const float *q = packet->items[i].quat_xyzw;
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !isfinite(q[0]) ||
        !isfinite(q[1]) || !isfinite(q[2]) || !isfinite(q[3])) {
      return false;
    }
  }
  return true;
}

cf_status_t cf_localization_packet_decode(cf_localization_packet_t *packet, uint8_t own_id,
                                          uint8_t channel, const uint8_t *data, int length) {
  cf_packet_reader_t       reader = cf_packet_reader(data, length);
  cf_localization_packet_t read   = {.request = CF_LOCALIZATION_ASKS_NOTHING};
  cf_status_t              status = CF_OK;
  if (channel == CF_LOCALIZATION_POSITION) {
    read_position(&read, own_id, &reader);
  } else if (channel == CF_LOCALIZATION_GENERIC) {
    status = decode_generic(&read, own_id, &reader);
  } else if (channel == CF_LOCALIZATION_PACKED_POSITIONS) {
    read_packed(&read, false, &reader);
  } else {
    status = CF_ERR_UNKNOWN;
  }

  if (status == CF_OK && (!cf_packet_is_read(&reader) || !are_items_finite(&read))) {
    status = CF_ERR_VALUE;
  }
  if (status == CF_OK) {
    *packet = read;
  }
  return status;
}
