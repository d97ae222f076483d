#include "arm_math.h"

arm_status arm_mat_mult_f32(const arm_matrix_instance_f32 *a, const arm_matrix_instance_f32 *b,
                            arm_matrix_instance_f32 *product) {
  if (a->numCols != b->numRows || product->numRows != a->numRows ||
      product->numCols != b->numCols) {
    return ARM_MATH_SIZE_MISMATCH;
  }
  for (int i = 0; i < a->numRows; i++) {
    for (int j = 0; j < b->numCols; j++) {
      float32_t sum = 0.0f;
      for (int k = 0; k < a->numCols; k++) {
        sum += a->pData[i * a->numCols + k] * b->pData[k * b->numCols + j];
      }
      product->pData[i * b->numCols + j] = sum;
    }
  }
  return ARM_MATH_SUCCESS;
}
