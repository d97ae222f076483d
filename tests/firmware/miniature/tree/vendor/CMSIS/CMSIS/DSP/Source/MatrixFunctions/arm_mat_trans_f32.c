#include "arm_math.h"

arm_status arm_mat_trans_f32(const arm_matrix_instance_f32 *a,
                             arm_matrix_instance_f32       *transposed) {
  for (int i = 0; i < a->numRows; i++) {
    for (int j = 0; j < a->numCols; j++) {
      transposed->pData[j * a->numRows + i] = a->pData[i * a->numCols + j];
    }
  }
  return ARM_MATH_SUCCESS;
}
