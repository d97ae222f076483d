#include "builtin/kalman/cholesky.h"

#include <math.h>
#include <stdbool.h>

#include "builtin/kalman/row9.h"

#define SMALLEST_ROOT 1e-4f  // stands in for the root of what is not positive

void cf_cholesky(float L[9][9], const float P[9][9]) {
  bool is_positive[9] = {false};
  for (int i = 0; i < 9; i++) {
    for (int j = 0; j < 9; j++) {
      L[i][j] = 0.0f;
    }
    for (int j = 0; j <= i; j++) {
      float sum = 0.0f;
      for (int k = 0; k < j; k++) {
        sum += L[i][k] * L[j][k];
      }
      if (i == j) {
        // NaN is none
        is_positive[i] = P[i][i] - sum > 0.0f;
        L[i][i]        = is_positive[i] ? sqrtf(P[i][i] - sum) : SMALLEST_ROOT;
      } else {
        L[i][j] = is_positive[j] ? (P[i][j] - sum) / L[j][j] : 0.0f;
      }
    }
  }
}

// Gauss-Jordan elimination: below the diagonal is all there is to eliminate.
void cf_invert_lower(float inverse[9][9], const float L[9][9]) {
  cf_row9_t rows[9];
  for (int i = 0; i < 9; i++) {
    rows[i] = cf_row9_with(cf_row9_zero(), i, 1.0f);
  }
  for (int k = 0; k < 9; k++) {
    rows[k] = cf_row9_over(rows[k], L[k][k]);
    for (int i = k + 1; i < 9; i++) {
      rows[i] = cf_row9_minus(rows[i], cf_row9_times(rows[k], L[i][k]));
    }
    cf_row9_store(inverse[k], rows[k]);
  }
}
