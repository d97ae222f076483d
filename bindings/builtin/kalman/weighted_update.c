#include "builtin/kalman/covariance.h"
#include "builtin/kalman/matrix9.h"

// P = (I - K H) P_w
void kalmanCoreUpdateWithPKE(kalmanCoreData_t *self, const float Hm[9], const float Km[9],
                             const float P_w_m[9][9], float error) {
  float N[KC_STATE_DIM][KC_STATE_DIM];
  for (int i = 0; i < KC_STATE_DIM; i++) {
    self->S[i] += Km[i] * error;
    for (int j = 0; j < KC_STATE_DIM; j++) {
      N[i][j] = -1.0f * (Km[i] * Hm[j]);
    }
    N[i][i] = 1.0f + N[i][i];
  }

  float     product[KC_STATE_DIM][KC_STATE_DIM];
  cf_row9_t P[KC_STATE_DIM];
  cf_matrix9_multiply(product, N, P_w_m);
  for (int i = 0; i < KC_STATE_DIM; i++) {
    P[i] = cf_row9_load(product[i]);
  }
  cf_covariance_bound(self, P);
  self->isUpdated = true;
}
