#include "arm_math.h"

arm_status arm_mat_scale_f32(const arm_matrix_instance_f32 *a, float32_t scale,
                             arm_matrix_instance_f32 *product) {
  for (int i = 0; i < a->numRows * a->numCols; i++) {
    product->pData[i] = a->pData[i] * scale;
  }
  return ARM_MATH_SUCCESS;
}
