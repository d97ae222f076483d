#include "log_packing.h"

#include <stddef.h>
#include <string.h>

#include "api/num.h"
#include "convert.h"

#define LOG_DATA_HEADER 0x5Eu  // port 5, channel 2, and the two reserved bits

typedef struct {
  int32_t whole;
  float   real;
} number_t;

static number_t from_whole(int32_t whole) {
  return (number_t){.whole = whole, .real = (float)whole};
}

// what lies there may be aligned or not
#define READ_WHOLE(type_)               \
  do {                                  \
    type_ value;                        \
    memcpy(&value, from, sizeof value); \
    return from_whole((int32_t)value);  \
  } while (0)

static number_t read_number(const void *from, uint8_t stored) {
  switch (stored) {
    case CF_LOG_UINT8:
      READ_WHOLE(uint8_t);
    case CF_LOG_UINT16:
      READ_WHOLE(uint16_t);
    case CF_LOG_UINT32:
      READ_WHOLE(uint32_t);
    case CF_LOG_INT8:
      READ_WHOLE(int8_t);
    case CF_LOG_INT16:
      READ_WHOLE(int16_t);
    case CF_LOG_INT32:
      READ_WHOLE(int32_t);
    default: {
      float value;
      memcpy(&value, from, sizeof value);
      return (number_t){.whole = cf_to_int32(value), .real = value};
    }
  }
}

int cf_log_value_bytes(uint8_t fetched) {
  static const uint8_t BYTES[] = {0, 1, 2, 4, 1, 2, 4, 4, 2};
  return fetched < sizeof BYTES ? BYTES[fetched] : 0;
}

// The low bytes of a number, the lowest first.
static void put_low_bytes(uint8_t *to, uint32_t number, int bytes) {
  for (int i = 0; i < bytes; i++) {
    to[i] = (uint8_t)(number >> 8 * i);
  }
}

static uint32_t bits_of(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static int put_value(uint8_t *to, const void *from, const cf_log_value_t *value) {
  const number_t number = read_number(from, value->stored);
  const int      bytes  = cf_log_value_bytes(value->fetched);
  if (value->fetched == CF_LOG_FLOAT) {
    put_low_bytes(to, bits_of(number.real), bytes);
  } else if (value->fetched == CF_LOG_FP16) {
    put_low_bytes(to, single2half(number.real), bytes);
  } else {
    put_low_bytes(to, (uint32_t)number.whole, bytes);
  }
  return bytes;
}

static void pack(const cf_log_block_t *block, uint8_t *packet) {
  packet[0] = LOG_DATA_HEADER;
  packet[1] = block->number;
  put_low_bytes(packet + 2, block->drone->onboard.tick, 3);

  uint8_t *end = packet + CF_LOG_HEADER_BYTES;
  for (int i = 0; i < block->count; i++) {
    const char *from = (const char *)block->drone + block->values[i].offset;
    end += put_value(end, from, &block->values[i]);
  }
}

void cf_log_pack(const cf_log_block_t *blocks, int count, uint8_t *packets) {
  const cf_t *fresh = NULL;
  for (int i = 0; i < count; i++) {
    cf_t *drone = blocks[i].drone;
    if (blocks[i].needs_refresh && drone != fresh) {
      cf_refresh_logs(drone, 1, 0);
      fresh = drone;
    }
    pack(&blocks[i], packets + (ptrdiff_t)i * CF_LOG_PACKET_BYTES);
  }
}
