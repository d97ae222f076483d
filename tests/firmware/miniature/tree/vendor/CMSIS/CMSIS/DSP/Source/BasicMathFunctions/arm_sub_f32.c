#include "arm_math.h"

void arm_sub_f32(float32_t *a, float32_t *b, float32_t *difference, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) {
    difference[i] = a[i] - b[i];
  }
}
