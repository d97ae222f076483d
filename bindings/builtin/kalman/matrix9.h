/* Dense products of 9 x 9 matrices, for the rarely used models. Internal to C. */
#ifndef CF_BUILTIN_KALMAN_MATRIX9_H
#define CF_BUILTIN_KALMAN_MATRIX9_H

#include "builtin/kalman/row9.h"

// out = A B, accumulated from k = 0 upward. out is neither A nor B.
static inline void cf_matrix9_multiply(float out[9][9], const float A[9][9], const float B[9][9]) {
  for (int i = 0; i < 9; i++) {
    cf_row9_t sum = cf_row9_zero();
    for (int k = 0; k < 9; k++) {
      sum = cf_row9_plus(sum, cf_row9_times(cf_row9_load(B[k]), A[i][k]));
    }
    cf_row9_store(out[i], sum);
  }
}

static inline void cf_matrix9_transpose(float out[9][9], const float A[9][9]) {
  for (int i = 0; i < 9; i++) {
    for (int j = 0; j < 9; j++) {
      out[i][j] = A[j][i];
    }
  }
}

#endif  // CF_BUILTIN_KALMAN_MATRIX9_H
