// What both robust models do, each with its own memory: to be included by one of them.
#pragma once

#include "kalman_core.h"
#include "static_mem.h"

#define N KC_STATE_DIM
#define MAX_ITER (2)
#define UPPER_BOUND (100)
#define LOWER_BOUND (-100)

// error and derivative at a state; false where there is none
typedef bool (*linearize_t)(const float X[N], const void *measurement, float *error, float H[N]);

static void choleskyDecomposition(float L[N][N], float P[N][N]) {
  for (int i = 0; i < N; i++) {
    for (int j = 0; j <= i; j++) {
      float sum = 0;
      for (int k = 0; k < j; k++) {
        sum += L[i][k] * L[j][k];
      }
      if (i == j) {
        L[i][j] = sqrtf(P[i][i] - sum);
      } else {
        L[i][j] = (P[i][j] - sum) / L[j][j];
      }
    }
  }
}

static float weight(float sigma, float e) {
  return sigma * sigma / ((sigma + e * e) * (sigma + e * e));
}

static void robustUpdate(kalmanCoreData_t *this, linearize_t linearize, const void *measurement,
                         float stdDev, float sigmaY, float sigmaX) {
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float L[N][N];
  static arm_matrix_instance_f32                                     Lm = {N, N, (float *)L};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float LT[N][N];
  static arm_matrix_instance_f32                                     LTm = {N, N, (float *)LT};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float W[N][N];
  static arm_matrix_instance_f32                                     Wm = {N, N, (float *)W};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float tmp[N][N];
  static arm_matrix_instance_f32                                     tmpm = {N, N, (float *)tmp};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float kept[N][N];
  static arm_matrix_instance_f32                                     keptm = {N, N, (float *)kept};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float P_w[N][N];
  static arm_matrix_instance_f32                                     P_wm = {N, N, (float *)P_w};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float K[N];
  static arm_matrix_instance_f32                                     Km = {N, 1, K};
  NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((aligned(4))) static float H[N];
  static arm_matrix_instance_f32                                     Hm = {1, N, H};

  // what the latest update corrected, still there at the next
  static float x_err[N];

  float X[N], R_iter = stdDev * stdDev, error, prior;
  memcpy(X, this->S, sizeof X);
  memcpy(P_w, this->P, sizeof P_w);
  if (!linearize(X, measurement, &prior, H)) {
    return;
  }

  for (int iter = 0; iter < MAX_ITER; iter++) {
    float H_iter[N];
    if (!linearize(X, measurement, &error, H_iter)) {
      break;
    }
    memcpy(H, H_iter, sizeof H);
    choleskyDecomposition(L, P_w);
    mat_trans(&Lm, &LTm);
    for (int i = 0; i < N; i++) {
      for (int j = 0; j <= i; j++) {
        const float least = i == j ? 0.0f : LOWER_BOUND;
        if (isnan(L[i][j]) || L[i][j] > UPPER_BOUND) {
          L[i][j] = UPPER_BOUND;
        } else if (L[i][j] < least) {
          L[i][j] = least;
        }
      }
      L[i][i] += 1e-9f;
    }

    const float R_chol = sqrtf(R_iter);
    const float e_y    = error / (fabsf(R_chol) < 1e-4f ? 1e-4f : R_chol);
    memcpy(kept, L, sizeof kept);
    mat_inv(&keptm, &tmpm);
    memset(W, 0, sizeof W);
    for (int i = 0; i < N; i++) {
      float e_x = 0;
      for (int k = 0; k < N; k++) {
        e_x += tmp[i][k] * x_err[k];
      }
      W[i][i] = 1.0f / weight(sigmaX, e_x);
    }
    mat_mult(&Lm, &Wm, &tmpm);
    mat_mult(&tmpm, &LTm, &P_wm);

    const float w_y = weight(sigmaY, e_y);
    R_iter          = R_chol * R_chol / (fabsf(w_y) < 1e-4f ? 1e-4f : w_y);
    float HPHR      = R_iter;
    for (int i = 0; i < N; i++) {
      K[i] = 0;
      for (int k = 0; k < N; k++) {
        K[i] += P_w[i][k] * H[k];
      }
      HPHR += H[i] * K[i];
    }
    for (int i = 0; i < N; i++) {
      K[i]     = K[i] / HPHR;
      x_err[i] = K[i] * prior;
      X[i]     = this->S[i] + x_err[i];
    }
  }
  kalmanCoreUpdateWithPKE(this, &Hm, &Km, &P_wm, prior);
}
