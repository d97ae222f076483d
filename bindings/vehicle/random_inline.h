/* The generator itself, for code that draws many numbers per tick. Internal to C. */
#ifndef CF_VEHICLE_RANDOM_INLINE_H
#define CF_VEHICLE_RANDOM_INLINE_H

#include <string.h>

#include "vehicle/random.h"

// |x| = offset + slope * f for a two-sided tail probability f / 2^31: 16 pieces for each of 31
// octaves, and one for the f that round up to 2^31
#define CF_NORMAL_LINE_COUNT 497
typedef struct {
  float offset;
  float slope;
} cf_normal_line_t;
extern const cf_normal_line_t CF_NORMAL_LINES[CF_NORMAL_LINE_COUNT];

static inline uint64_t cf_rotate_left(uint64_t x, int by) {
  return (x << by) | (x >> (64 - by));
}

// xoroshiro128++
static inline uint64_t cf_next_bits(cf_random_t *random) {
  const uint64_t a      = random->state[0];
  const uint64_t b      = random->state[1] ^ a;
  const uint64_t result = cf_rotate_left(a + random->state[1], 17) + a;
  random->state[0]      = cf_rotate_left(a, 49) ^ b ^ (b << 21);
  random->state[1]      = cf_rotate_left(b, 28);
  return result;
}

static inline float cf_normal_from_bits(uint32_t bits) {
  // odd, so never 0: the middle of two neighbors
  const float f = (float)(int32_t)((bits & 0x7fffffffu) | 1u);

  // exponent and upper four bits of the mantissa tell the piece
  uint32_t pattern;
  memcpy(&pattern, &f, sizeof pattern);
  const cf_normal_line_t line      = CF_NORMAL_LINES[(pattern >> 19) - (0x3f800000u >> 19)];
  const float            magnitude = line.offset + line.slope * f;

  // take over the sign without a branch
  float normal;
  memcpy(&pattern, &magnitude, sizeof pattern);
  pattern ^= bits & 0x80000000u;
  memcpy(&normal, &pattern, sizeof normal);
  return normal;
}

// Writes an even number of standard normal numbers, two per 64 bits.
static inline void cf_next_normals(cf_random_t *random, float *numbers, int even_count) {
  cf_random_t local = *random;
  for (int i = 0; i < even_count; i += 2) {
    const uint64_t bits = cf_next_bits(&local);
    numbers[i]          = cf_normal_from_bits((uint32_t)(bits >> 32));
    numbers[i + 1]      = cf_normal_from_bits((uint32_t)bits);
  }
  *random = local;
}

#endif  // CF_VEHICLE_RANDOM_INLINE_H
