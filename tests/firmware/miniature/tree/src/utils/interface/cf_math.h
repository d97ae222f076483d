// Wrappers of the DSP library that assert what it returns.
#pragma once

#include "arm_math.h"
#include "cfassert.h"

#define DEG_TO_RAD (PI / 180.0f)
#define RAD_TO_DEG (180.0f / PI)

#define MIN(a, b) ((b) < (a) ? (b) : (a))
#define MAX(a, b) ((b) > (a) ? (b) : (a))

// the vehicle's processor wants matrices at multiples of 4
#define ASSERT_ALIGNED(matrix) ASSERT(((uint32_t)(uintptr_t)(matrix)->pData & 3u) == 0)

static inline void mat_trans(const arm_matrix_instance_f32 *pSrc, arm_matrix_instance_f32 *pDst) {
  ASSERT_ALIGNED(pSrc);
  ASSERT_ALIGNED(pDst);
  ASSERT(ARM_MATH_SUCCESS == arm_mat_trans_f32(pSrc, pDst));
}

static inline void mat_inv(const arm_matrix_instance_f32 *pSrc, arm_matrix_instance_f32 *pDst) {
  ASSERT_ALIGNED(pSrc);
  ASSERT_ALIGNED(pDst);
  ASSERT(ARM_MATH_SUCCESS == arm_mat_inverse_f32(pSrc, pDst));
}

static inline void mat_mult(const arm_matrix_instance_f32 *pSrcA,
                            const arm_matrix_instance_f32 *pSrcB, arm_matrix_instance_f32 *pDst) {
  ASSERT_ALIGNED(pSrcA);
  ASSERT_ALIGNED(pSrcB);
  ASSERT_ALIGNED(pDst);
  ASSERT(ARM_MATH_SUCCESS == arm_mat_mult_f32(pSrcA, pSrcB, pDst));
}

static inline void mat_scale(const arm_matrix_instance_f32 *pSrcA, float32_t scale,
                             arm_matrix_instance_f32 *pDst) {
  ASSERT(ARM_MATH_SUCCESS == arm_mat_scale_f32(pSrcA, scale, pDst));
}

static inline float arm_sqrt(float32_t in) {
  float      pOut   = 0;
  arm_status result = arm_sqrt_f32(in, &pOut);
  ASSERT(ARM_MATH_SUCCESS == result);
  return pOut;
}

static inline float limPos(float in) {
  return in < 0.0f ? 0.0f : in;
}

static inline float clip1(float a) {
  return a < -1.0f ? -1.0f : (a > 1.0f ? 1.0f : a);
}
