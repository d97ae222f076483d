#include "arm_math.h"

void arm_dot_prod_f32(float32_t *a, float32_t *b, uint32_t n, float32_t *result) {
  float32_t sum = 0.0f;
  for (uint32_t i = 0; i < n; i++) {
    sum += a[i] * b[i];
  }
  *result = sum;
}
