// The few functions of the DSP library that the firmware calls.
#ifndef ARM_MATH_H
#define ARM_MATH_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "cmsis_compiler.h"

#define PI 3.14159265358979f
#define FAST_MATH_TABLE_SIZE 512

typedef float float32_t;

typedef enum {
  ARM_MATH_SUCCESS        = 0,
  ARM_MATH_ARGUMENT_ERROR = -1,
  ARM_MATH_SIZE_MISMATCH  = -3,
  ARM_MATH_SINGULAR       = -5,
} arm_status;

typedef struct {
  uint16_t   numRows;
  uint16_t   numCols;
  float32_t *pData;
} arm_matrix_instance_f32;

extern const float32_t sinTable_f32[FAST_MATH_TABLE_SIZE + 1];

float32_t arm_sin_f32(float32_t x);
float32_t arm_cos_f32(float32_t x);

void arm_add_f32(float32_t *a, float32_t *b, float32_t *sum, uint32_t n);
void arm_sub_f32(float32_t *a, float32_t *b, float32_t *difference, uint32_t n);
void arm_scale_f32(float32_t *a, float32_t scale, float32_t *product, uint32_t n);
void arm_dot_prod_f32(float32_t *a, float32_t *b, uint32_t n, float32_t *result);
void arm_power_f32(float32_t *a, uint32_t n, float32_t *result);

arm_status arm_mat_trans_f32(const arm_matrix_instance_f32 *a, arm_matrix_instance_f32 *transposed);
arm_status arm_mat_mult_f32(const arm_matrix_instance_f32 *a, const arm_matrix_instance_f32 *b,
                            arm_matrix_instance_f32 *product);
arm_status arm_mat_scale_f32(const arm_matrix_instance_f32 *a, float32_t scale,
                             arm_matrix_instance_f32 *product);
arm_status arm_mat_inverse_f32(const arm_matrix_instance_f32 *a, arm_matrix_instance_f32 *inverse);

__STATIC_FORCEINLINE arm_status arm_sqrt_f32(float32_t in, float32_t *root) {
  *root = in >= 0.0f ? sqrtf(in) : 0.0f;
  return in >= 0.0f ? ARM_MATH_SUCCESS : ARM_MATH_ARGUMENT_ERROR;
}

#endif  // ARM_MATH_H
