#include "arm_math.h"

static void swap_rows(float32_t *x, float32_t *y, int n) {
  for (int j = 0; j < n; j++) {
    const float32_t kept = x[j];
    x[j]                 = y[j];
    y[j]                 = kept;
  }
}

// Gauss-Jordan elimination, which destroys its source.
arm_status arm_mat_inverse_f32(const arm_matrix_instance_f32 *a, arm_matrix_instance_f32 *inverse) {
  const int  n  = a->numRows;
  float32_t *in = a->pData, *out = inverse->pData;
  memset(out, 0, sizeof(float32_t) * (size_t)(n * n));
  for (int i = 0; i < n; i++) {
    out[i * n + i] = 1.0f;
  }
  for (int k = 0; k < n; k++) {
    int pivot = k;
    while (pivot < n && in[pivot * n + k] == 0.0f) {
      pivot++;
    }
    if (pivot == n) {
      return ARM_MATH_SINGULAR;
    }
    swap_rows(&in[k * n], &in[pivot * n], n);
    swap_rows(&out[k * n], &out[pivot * n], n);
    const float32_t d = in[k * n + k];
    for (int j = 0; j < n; j++) {
      in[k * n + j]  = in[k * n + j] / d;
      out[k * n + j] = out[k * n + j] / d;
    }
    for (int i = 0; i < n; i++) {
      const float32_t factor = in[i * n + k];
      if (i != k && factor != 0.0f) {
        for (int j = 0; j < n; j++) {
          in[i * n + j] -= in[k * n + j] * factor;
          out[i * n + j] -= out[k * n + j] * factor;
        }
      }
    }
  }
  return ARM_MATH_SUCCESS;
}
