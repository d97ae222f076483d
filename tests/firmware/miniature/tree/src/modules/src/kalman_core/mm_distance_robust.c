// clang-format off
#include "mm_distance_robust.h"
#include "test_support.h"
// clang-format on

#define MAX_ITER (2)
#define UPPER_BOUND (100)
#define LOWER_BOUND (-100)

static void Cholesky_Decomposition(int n, float matrix[n][n], float lower[n][n]) {
  for (int i = 0; i < n; i++) {
    for (int j = 0; j <= i; j++) {
      float sum = 0;
      for (int k = 0; k < j; k++) {
        sum += lower[i][k] * lower[j][k];
      }
      if (i == j) {
        lower[i][j] = sqrtf(matrix[i][i] - sum);
      } else {
        lower[i][j] = (matrix[i][j] - sum) / lower[j][j];
      }
    }
  }
}

static void GM_UWB(float e, float *GM_e) {
  float sigma = 1.5f;
  *GM_e       = sigma * sigma / ((sigma + e * e) * (sigma + e * e));
}

static void GM_state(float e, float *GM_e) {
  float sigma = 2.0f;
  *GM_e       = sigma * sigma / ((sigma + e * e) * (sigma + e * e));
}

// Error and derivative at a state.
static bool linearize(const float X[KC_STATE_DIM], const distanceMeasurement_t *d, float *error,
                      float h[KC_STATE_DIM]) {
  const float dx = X[0] - d->x, dy = X[1] - d->y, dz = X[2] - d->z;
  const float predicted = sqrtf(dx * dx + dy * dy + dz * dz);
  memset(h, 0, sizeof(float[KC_STATE_DIM]));
  *error = d->distance - predicted;
  h[0]   = predicted != 0.0f ? dx / predicted : 1.0f;
  h[1]   = predicted != 0.0f ? dy / predicted : 0.0f;
  h[2]   = predicted != 0.0f ? dz / predicted : 0.0f;
  return true;
}

void kalmanCoreRobustUpdateWithDistance(kalmanCoreData_t *this, distanceMeasurement_t *d) {
  static float                   P_chol[KC_STATE_DIM][KC_STATE_DIM];
  static arm_matrix_instance_f32 Pc_m = {KC_STATE_DIM, KC_STATE_DIM, (float *)P_chol};
  static float                   Pc_tran[KC_STATE_DIM][KC_STATE_DIM];
  static arm_matrix_instance_f32 Pc_tran_m = {KC_STATE_DIM, KC_STATE_DIM, (float *)Pc_tran};
  static float                   Wx_inv[KC_STATE_DIM][KC_STATE_DIM];
  static arm_matrix_instance_f32 Wx_invm = {KC_STATE_DIM, KC_STATE_DIM, (float *)Wx_inv};
  static float                   tmp[KC_STATE_DIM][KC_STATE_DIM];
  static arm_matrix_instance_f32 tmpm = {KC_STATE_DIM, KC_STATE_DIM, (float *)tmp};
  static float                   kept[KC_STATE_DIM][KC_STATE_DIM];
  static arm_matrix_instance_f32 keptm = {KC_STATE_DIM, KC_STATE_DIM, (float *)kept};
  static float                   P_w[KC_STATE_DIM][KC_STATE_DIM];
  static arm_matrix_instance_f32 P_w_m = {KC_STATE_DIM, KC_STATE_DIM, (float *)P_w};
  static float                   Kw[KC_STATE_DIM];
  static arm_matrix_instance_f32 Kwm = {KC_STATE_DIM, 1, (float *)Kw};
  static float                   h[KC_STATE_DIM];
  static arm_matrix_instance_f32 H = {1, KC_STATE_DIM, h};

  // what the latest update corrected, still there at the next
  static float x_err[KC_STATE_DIM];

  float X[KC_STATE_DIM], R_iter = d->stdDev * d->stdDev, error, prior;
  memcpy(X, this->S, sizeof X);
  memcpy(P_w, this->P, sizeof P_w);
  if (!linearize(X, d, &prior, h)) {
    return;
  }

  for (int iter = 0; iter < MAX_ITER; iter++) {
    float h_iter[KC_STATE_DIM];
    if (!linearize(X, d, &error, h_iter)) {
      break;
    }
    memcpy(h, h_iter, sizeof h);
    Cholesky_Decomposition(KC_STATE_DIM, P_w, P_chol);
    mat_trans(&Pc_m, &Pc_tran_m);
    for (int i = 0; i < KC_STATE_DIM; i++) {
      for (int j = 0; j <= i; j++) {
        const float least = i == j ? 0.0f : LOWER_BOUND;
        if (isnan(P_chol[i][j]) || P_chol[i][j] > UPPER_BOUND) {
          P_chol[i][j] = UPPER_BOUND;
        } else if (P_chol[i][j] < least) {
          P_chol[i][j] = least;
        }
      }
      P_chol[i][i] += 1e-9f;
    }

    const float R_chol = sqrtf(R_iter);
    const float e_y    = error / (fabsf(R_chol) < 1e-4f ? 1e-4f : R_chol);
    memcpy(kept, P_chol, sizeof kept);
    mat_inv(&keptm, &tmpm);
    memset(Wx_inv, 0, sizeof Wx_inv);
    for (int i = 0; i < KC_STATE_DIM; i++) {
      float e_x = 0, w_x = 0;
      for (int k = 0; k < KC_STATE_DIM; k++) {
        e_x += tmp[i][k] * x_err[k];
      }
      GM_state(e_x, &w_x);
      Wx_inv[i][i] = 1.0f / w_x;
    }
    mat_mult(&Pc_m, &Wx_invm, &tmpm);
    mat_mult(&tmpm, &Pc_tran_m, &P_w_m);

    float w_y = 0;
    GM_UWB(e_y, &w_y);
    R_iter     = R_chol * R_chol / (fabsf(w_y) < 1e-4f ? 1e-4f : w_y);
    float HPHR = R_iter;
    for (int i = 0; i < KC_STATE_DIM; i++) {
      Kw[i] = 0;
      for (int k = 0; k < KC_STATE_DIM; k++) {
        Kw[i] += P_w[i][k] * h[k];
      }
      HPHR += h[i] * Kw[i];
    }
    for (int i = 0; i < KC_STATE_DIM; i++) {
      Kw[i]    = Kw[i] / HPHR;
      x_err[i] = Kw[i] * prior;
      X[i]     = this->S[i] + x_err[i];
    }
  }
  kalmanCoreUpdateWithPKE(this, &H, &Kwm, &P_w_m, prior);
}
