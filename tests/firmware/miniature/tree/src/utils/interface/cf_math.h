// Wrappers of the DSP library that assert what it returns.
#pragma once

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wfloat-conversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpointer-to-int-cast"
// clang-format off
#include "arm_math.h"
#pragma GCC diagnostic pop

#include "cfassert.h"
// clang-format on

#define DEG_TO_RAD (PI / 180.0f)
#define RAD_TO_DEG (180.0f / PI)

#define MIN(a, b) ((b) < (a) ? (b) : (a))
#define MAX(a, b) ((b) > (a) ? (b) : (a))

// Matrices lie at multiples of 4: asked of 32-bit pointers, which a host's are not.
static inline void assert_aligned_4_bytes(const arm_matrix_instance_f32 *matrix) {
  const uint32_t address = (uint32_t)matrix->pData;
  ASSERT((address & 0x3) == 0);
}

static inline void mat_trans(const arm_matrix_instance_f32 *pSrc, arm_matrix_instance_f32 *pDst) {
  assert_aligned_4_bytes(pSrc);
  assert_aligned_4_bytes(pDst);
  ASSERT(ARM_MATH_SUCCESS == arm_mat_trans_f32(pSrc, pDst));
}

static inline void mat_inv(const arm_matrix_instance_f32 *pSrc, arm_matrix_instance_f32 *pDst) {
  assert_aligned_4_bytes(pSrc);
  assert_aligned_4_bytes(pDst);
  ASSERT(ARM_MATH_SUCCESS == arm_mat_inverse_f32(pSrc, pDst));
}

static inline void mat_mult(const arm_matrix_instance_f32 *pSrcA,
                            const arm_matrix_instance_f32 *pSrcB, arm_matrix_instance_f32 *pDst) {
  assert_aligned_4_bytes(pSrcA);
  assert_aligned_4_bytes(pSrcB);
  assert_aligned_4_bytes(pDst);
  ASSERT(ARM_MATH_SUCCESS == arm_mat_mult_f32(pSrcA, pSrcB, pDst));
}

static inline void mat_scale(const arm_matrix_instance_f32 *pSrcA, float32_t scale,
                             arm_matrix_instance_f32 *pDst) {
  assert_aligned_4_bytes(pSrcA);
  assert_aligned_4_bytes(pDst);
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
