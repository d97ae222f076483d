#include "arm_math.h"

void arm_scale_f32(float32_t *a, float32_t scale, float32_t *product, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) {
    product[i] = a[i] * scale;
  }
}
