#include "vehicle/random.h"

#include <string.h>

#include "vehicle/random_table.h"

// 16 pieces per octave: four bits of the mantissa continue the exponent
#define PIECE_SHIFT 19
#define FIRST_PIECE (0x3f800000u >> PIECE_SHIFT)

static uint64_t rotate_left(uint64_t x, int by) {
  return (x << by) | (x >> (64 - by));
}

// splitmix64: one step of a counter, scrambled
static uint64_t scramble(uint64_t *counter) {
  uint64_t z = (*counter += 0x9e3779b97f4a7c15u);
  z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z          = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

void cf_random_init(cf_random_t *random, uint64_t seed, uint64_t id) {
  // the id goes through the scrambler on its own, so that (seed, id) and (id, seed) differ
  uint64_t counter = id;
  counter          = scramble(&counter) ^ seed;
  random->state[0] = scramble(&counter);
  random->state[1] = scramble(&counter);
  if ((random->state[0] | random->state[1]) == 0) {
    random->state[0] = 1;
  }
}

cf_random_t cf_random_split(cf_random_t *random) {
  cf_random_t    child;
  const uint64_t seed = cf_random_bits(random);
  cf_random_init(&child, seed, cf_random_bits(random));
  return child;
}

uint64_t cf_random_bits(cf_random_t *random) {
  // xoroshiro128++
  const uint64_t a      = random->state[0];
  const uint64_t b      = random->state[1] ^ a;
  const uint64_t result = rotate_left(a + random->state[1], 17) + a;
  random->state[0]      = rotate_left(a, 49) ^ b ^ (b << 21);
  random->state[1]      = rotate_left(b, 28);
  return result;
}

float cf_random_uniform(cf_random_t *random) {
  return (float)(cf_random_bits(random) >> 40) * 0x1p-24f;
}

static inline float normal_from_bits(uint32_t bits) {
  // odd, so never 0: the middle of two neighbours
  const float f = (float)(int32_t)((bits & 0x7fffffffu) | 1u);

  uint32_t pattern;
  memcpy(&pattern, &f, sizeof pattern);
  const uint32_t piece     = (pattern >> PIECE_SHIFT) - FIRST_PIECE;
  const float    magnitude = NORMAL_LINES[piece].offset + NORMAL_LINES[piece].slope * f;

  // copy the sign without a branch
  float normal;
  memcpy(&pattern, &magnitude, sizeof pattern);
  pattern ^= bits & 0x80000000u;
  memcpy(&normal, &pattern, sizeof normal);
  return normal;
}

float cf_random_normal_from_bits(uint32_t bits) {
  return normal_from_bits(bits);
}

float cf_random_normal(cf_random_t *random) {
  return normal_from_bits((uint32_t)(cf_random_bits(random) >> 32));
}

void cf_random_normals(cf_random_t *random, float *numbers, int count) {
  cf_random_t local = *random;
  for (int i = 0; i < count; i += 2) {
    const uint64_t bits = cf_random_bits(&local);
    numbers[i]          = normal_from_bits((uint32_t)(bits >> 32));
    if (i + 1 < count) {
      numbers[i + 1] = normal_from_bits((uint32_t)bits);
    }
  }
  *random = local;
}
