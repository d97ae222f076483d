#include "arm_math.h"

void arm_add_f32(float32_t *a, float32_t *b, float32_t *sum, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) {
    sum[i] = a[i] + b[i];
  }
}
