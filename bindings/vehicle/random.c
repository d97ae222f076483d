#include "vehicle/random.h"

#include "vehicle/random_inline.h"

// splitmix64: one step of a counter, scrambled
static uint64_t scramble(uint64_t *counter) {
  uint64_t z = (*counter += 0x9e3779b97f4a7c15u);
  z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z          = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

void cf_random_init(cf_random_t *random, uint64_t seed, uint64_t id) {
  // the id is scrambled first, so that (seed, id) and (id, seed) differ
  uint64_t counter = id;
  counter          = scramble(&counter) ^ seed;
  random->state[0] = scramble(&counter);
  random->state[1] = scramble(&counter);
  // it would stay there; no seed is known that leads to it
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
  return cf_next_bits(random);
}

float cf_random_uniform(cf_random_t *random) {
  return (float)(cf_next_bits(random) >> 40) * 0x1p-24f;
}

float cf_random_normal(cf_random_t *random) {
  return cf_normal_from_bits((uint32_t)(cf_next_bits(random) >> 32));
}

void cf_random_normals(cf_random_t *random, float *numbers, int count) {
  if (count <= 0) {
    return;
  }
  const int pairs = count & ~1;
  cf_next_normals(random, numbers, pairs);
  if (pairs < count) {
    numbers[pairs] = cf_random_normal(random);
  }
}

float cf_random_normal_from_bits(uint32_t bits) {
  return cf_normal_from_bits(bits);
}
