/* Reads little-endian numbers out of a packet and never past its end. Internal to C.
 *
 * Reading behind the end gives 0 and is remembered, so that a decoder reads all of its fields first
 * and then asks once, with cf_packet_is_read, whether the packet had exactly this length. */
#ifndef CF_ONBOARD_PACKETS_PACKET_READER_H
#define CF_ONBOARD_PACKETS_PACKET_READER_H

#include <stdbool.h>
#include <stdint.h>

#include "little_endian.h"

typedef struct {
  const uint8_t *data;
  int            length;  // [bytes]
  int            at;      // [bytes], of the next one
  bool           is_short;
} cf_packet_reader_t;

static inline cf_packet_reader_t cf_packet_reader(const uint8_t *data, int length) {
  return (cf_packet_reader_t){.data = data, .length = length};
}

// Everything was read, and nothing was missing.
static inline bool cf_packet_is_read(const cf_packet_reader_t *reader) {
  return !reader->is_short && reader->at == reader->length;
}

// The place of the next `count` bytes, or of zeros when they are not all there.
static inline const uint8_t *cf_read_bytes(cf_packet_reader_t *reader, int count) {
  static const uint8_t NOTHING[4] = {0};
  if (reader->length - reader->at < count) {
    reader->is_short = true;
    return NOTHING;
  }
  const uint8_t *bytes = reader->data + reader->at;
  reader->at += count;
  return bytes;
}

static inline uint8_t cf_read_u8(cf_packet_reader_t *reader) {
  return *cf_read_bytes(reader, 1);
}

static inline uint16_t cf_read_u16(cf_packet_reader_t *reader) {
  return cf_le_u16(cf_read_bytes(reader, 2));
}

static inline uint32_t cf_read_u32(cf_packet_reader_t *reader) {
  return cf_le_u32(cf_read_bytes(reader, 4));
}

static inline int16_t cf_read_i16(cf_packet_reader_t *reader) {
  return (int16_t)cf_read_u16(reader);
}

static inline float cf_read_float(cf_packet_reader_t *reader) {
  return cf_le_float(cf_read_bytes(reader, 4));
}

static inline void cf_read_floats(cf_packet_reader_t *reader, float *values, int count) {
  for (int i = 0; i < count; i++) {
    values[i] = cf_read_float(reader);
  }
}

// Numbers in thousandths, as packed packets carry lengths in millimeters.
static inline void cf_read_thousandths(cf_packet_reader_t *reader, float *values, int count) {
  for (int i = 0; i < count; i++) {
    values[i] = (float)cf_read_i16(reader) / 1000.0f;
  }
}

#endif  // CF_ONBOARD_PACKETS_PACKET_READER_H
