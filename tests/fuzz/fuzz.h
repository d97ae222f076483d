/* What the fuzz targets share: bytes to be read as numbers, and a drone that must survive them.
 *
 * Each target is one function for libFuzzer, LLVMFuzzerTestOneInput. Without libFuzzer the same
 * function runs under random_driver.c, so that every build tries it. */
#ifndef CF_TEST_FUZZ_H
#define CF_TEST_FUZZ_H

#include <stddef.h>
#include <stdint.h>

#include "crazyflie.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// The input of a target, read from the front. Behind the end everything is 0.
typedef struct {
  const uint8_t *data;
  size_t         left;
} fuzz_input_t;

uint8_t  fuzz_u8(fuzz_input_t *input);
uint16_t fuzz_u16(fuzz_input_t *input);

// Any bits at all: NaN, infinities, denormal and huge numbers among them.
float fuzz_float(fuzz_input_t *input);

// Copies `size` bytes, zeros behind the end.
void fuzz_bytes(fuzz_input_t *input, void *bytes, size_t size);

// A drone that hovers 1 m high; its platform and positioning depend on `number`.
void fuzz_hovering_drone(cf_t *cf, uint8_t number);

// Runs `ticks` milliseconds with the body at rest in the air, and checks after each of them that
// what reaches the plant is finite, and that a stopped drone is locked and says why.
void fuzz_run(cf_t *cf, int ticks);

#endif  // CF_TEST_FUZZ_H
