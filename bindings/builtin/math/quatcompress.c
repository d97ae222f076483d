#include "api/quatcompress.h"

#include <math.h>

#define SQRT_HALF 0.70710678118654752440f  // no component but the largest can be larger
#define STEPS 511.0f
#define LARGEST_MAGNITUDE 511u

static int largest_component(const float q[4]) {
  int largest = 0;
  for (int i = 1; i < 4; i++) {
    if (fabsf(q[i]) > fabsf(q[largest])) {
      largest = i;
    }
  }
  return largest;
}

static uint32_t magnitude(float component) {
  const float steps = STEPS * (fabsf(component) / SQRT_HALF) + 0.5f;
  // negated, so that NaN is limited as well
  return !(steps < STEPS) ? LARGEST_MAGNITUDE : (uint32_t)steps;
}

uint32_t quatcompress(const float q[4]) {
  const int      largest = largest_component(q);
  const uint32_t is_flip = q[largest] < 0.0f;

  uint32_t word = (uint32_t)largest;
  for (int i = 0; i < 4; i++) {
    if (i != largest) {
      const uint32_t sign = (uint32_t)(q[i] < 0.0f) ^ is_flip;
      word                = word << 10 | sign << 9 | magnitude(q[i]);
    }
  }
  return word;
}

void quatdecompress(uint32_t comp, float q[4]) {
  const int largest = (int)(comp >> 30);

  float sum = 0.0f;
  for (int i = 3; i >= 0; i--) {
    if (i != largest) {
      const float size = SQRT_HALF * (float)(comp & LARGEST_MAGNITUDE) / STEPS;
      q[i]             = (comp >> 9 & 1u) != 0 ? -size : size;
      comp >>= 10;
      sum += q[i] * q[i];
    }
  }
  q[largest] = sqrtf(1.0f - sum);
}
