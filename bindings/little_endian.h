/* Little-endian numbers out of bytes and into them, on any machine. The caller knows that they are
 * there.
 * Internal to C. */
#ifndef CF_LITTLE_ENDIAN_H
#define CF_LITTLE_ENDIAN_H

#include <stdint.h>
#include <string.h>

static inline uint16_t cf_le_u16(const uint8_t *bytes) {
  return (uint16_t)(bytes[0] | bytes[1] << 8);
}

static inline uint32_t cf_le_u32(const uint8_t *bytes) {
  return (uint32_t)cf_le_u16(bytes) | (uint32_t)cf_le_u16(bytes + 2) << 16;
}

static inline float cf_le_float(const uint8_t *bytes) {
  const uint32_t bits = cf_le_u32(bytes);
  float          value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static inline void cf_put_le_u32(uint8_t *bytes, uint32_t value) {
  for (int i = 0; i < 4; i++) {
    bytes[i] = (uint8_t)(value >> 8 * i);
  }
}

static inline void cf_put_le_float(uint8_t *bytes, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  cf_put_le_u32(bytes, bits);
}

#endif  // CF_LITTLE_ENDIAN_H
