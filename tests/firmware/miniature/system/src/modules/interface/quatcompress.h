// A unit quaternion x, y, z, w in 32 bits: index of the largest component, then sign and nine bits
// of each of the others.
#pragma once

#include <math.h>
#include <stdint.h>

static inline uint32_t quatcompress(const float q[4]) {
  int largest = 0;
  for (int i = 1; i < 4; i++) {
    if (fabsf(q[i]) > fabsf(q[largest])) {
      largest = i;
    }
  }
  const uint32_t flips = q[largest] < 0.0f;

  uint32_t comp = (uint32_t)largest;
  for (int i = 0; i < 4; i++) {
    if (i != largest) {
      const uint32_t sign  = (uint32_t)(q[i] < 0.0f) ^ flips;
      const float    steps = 511.0f * (fabsf(q[i]) / (float)M_SQRT1_2) + 0.5f;
      const uint32_t mag   = !(steps < 511.0f) ? 511u : (uint32_t)steps;
      comp                 = comp << 10 | sign << 9 | mag;
    }
  }
  return comp;
}

static inline void quatdecompress(uint32_t comp, float q[4]) {
  const int largest = (int)(comp >> 30);
  float     sum     = 0.0f;
  for (int i = 3; i >= 0; i--) {
    if (i != largest) {
      const float size = (float)M_SQRT1_2 * (float)(comp & 511u) / 511.0f;
      q[i]             = (comp >> 9 & 1u) != 0 ? -size : size;
      comp >>= 10;
      sum += q[i] * q[i];
    }
  }
  q[largest] = sqrtf(1.0f - sum);
}
