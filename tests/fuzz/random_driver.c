/* Runs a fuzz target without libFuzzer: a fixed number of inputs from a fixed generator, half of
 * them pure noise, half of them made of numbers that break programs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

#define INPUTS 400
#define LARGEST 700

static uint64_t next(uint64_t *state) {
  *state ^= *state << 13;
  *state ^= *state >> 7;
  *state ^= *state << 17;
  return *state;
}

static const uint32_t NASTY[] = {
    0x7fc00000, 0x7f800000, 0xff800000, 0x7f7fffff, 0xff7fffff, 0x00000001, 0x80000000, 0x3f800000,
    0xbf800000, 0x00000000, 0xffffffff, 0x4f000000, 0xcf000000, 0x5f000000, 0x42c80000, 0x3dcccccd,
};

static void fill(uint8_t *data, size_t size, uint64_t *state) {
  const bool is_nasty = next(state) % 2 == 0;
  for (size_t i = 0; i < size; i += 4) {
    const bool     use_list = is_nasty && next(state) % 3 != 0;
    const uint32_t word     = use_list ? NASTY[next(state) % 16] : (uint32_t)(next(state) >> 32);
    memcpy(data + i, &word, size - i < 4 ? size - i : 4);
  }
}

int main(void) {
  uint64_t state = 0x9e3779b97f4a7c15u;
  for (int i = 0; i < INPUTS; i++) {
    const size_t size = next(&state) % LARGEST;
    uint8_t     *data = malloc(size + 1);  // on the heap, so that the sanitizer sees its end
    fill(data, size, &state);
    LLVMFuzzerTestOneInput(data, size);
    free(data);
  }
  printf("%d inputs\n", INPUTS);
  return 0;
}
