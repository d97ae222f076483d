#include "builtin/kalman/robust_update.h"

#include <math.h>
#include <string.h>

#include "builtin/kalman/cholesky.h"
#include "builtin/kalman/matrix9.h"

#define ROUNDS 2
#define SMALLEST 1e-4f       // stands in for smaller divisors
#define LARGEST_ROOT 100.0f  // entries of the root of the covariance are within +- this
#define ADDED_TO_ROOT 1e-9f  // keeps the diagonal of the root from zero

// w = sigma^2 / (sigma + e^2)^2
static float weight(float sigma, float e) {
  const float width = sigma + e * e;
  return sigma * sigma / (width * width);
}

static float at_least_smallest(float x) {
  return fabsf(x) < SMALLEST ? SMALLEST : x;
}

static void limit_root(float L[KC_STATE_DIM][KC_STATE_DIM]) {
  for (int i = 0; i < KC_STATE_DIM; i++) {
    for (int j = 0; j <= i; j++) {
      const float least = i == j ? 0.0f : -LARGEST_ROOT;
      // written so that NaN becomes the largest
      const float limited = L[i][j] <= LARGEST_ROOT ? L[i][j] : LARGEST_ROOT;
      L[i][j]             = limited < least ? least : limited;
    }
    L[i][i] += ADDED_TO_ROOT;
  }
}

// P_w = L W^-1 L', where the weights W are those of the errors L^-1 x_err.
static void weight_covariance(float P[KC_STATE_DIM][KC_STATE_DIM], const float x_err[KC_STATE_DIM],
                              float sigma) {
  float L[KC_STATE_DIM][KC_STATE_DIM];
  float transposed[KC_STATE_DIM][KC_STATE_DIM];
  cf_cholesky(L, P);
  cf_matrix9_transpose(transposed, L);  // before the limits, as the firmware does
  limit_root(L);

  float inverse[KC_STATE_DIM][KC_STATE_DIM];
  cf_invert_lower(inverse, L);
  float divisor[KC_STATE_DIM];
  for (int i = 0; i < KC_STATE_DIM; i++) {
    float e = 0.0f;
    for (int k = 0; k < KC_STATE_DIM; k++) {
      e += inverse[i][k] * x_err[k];
    }
    divisor[i] = 1.0f / weight(sigma, e);
  }
  for (int i = 0; i < KC_STATE_DIM; i++) {
    for (int j = 0; j < KC_STATE_DIM; j++) {
      L[i][j] *= divisor[j];
    }
  }

  // dense, so that an infinite divisor does what it does in the firmware
  cf_matrix9_multiply(P, L, transposed);
}

// K = P H' / (H P H' + R)
static void gain(float K[KC_STATE_DIM], const float P[KC_STATE_DIM][KC_STATE_DIM],
                 const float H[KC_STATE_DIM], float R) {
  float s = R;
  for (int i = 0; i < KC_STATE_DIM; i++) {
    K[i] = 0.0f;
    for (int k = 0; k < KC_STATE_DIM; k++) {
      K[i] += P[i][k] * H[k];
    }
    s += H[i] * K[i];
  }
  for (int i = 0; i < KC_STATE_DIM; i++) {
    K[i] = K[i] / s;
  }
}

void cf_robust_update(kalmanCoreData_t *core, const cf_robust_model_t *model,
                      const void *measurement, float std_dev, float x_err[KC_STATE_DIM]) {
  cf_linearization_t at = model->linearize(core->S, measurement);
  if (!at.has_derivative) {
    return;
  }
  const float prior_error = at.error;

  float X[KC_STATE_DIM];
  float P[KC_STATE_DIM][KC_STATE_DIM];
  float K[KC_STATE_DIM];
  float H[KC_STATE_DIM];
  float R = std_dev * std_dev;
  memcpy(X, core->S, sizeof(X));
  memcpy(P, core->P, sizeof(P));

  // the first round sees the same state as above, so that K and H are always made here
  for (int round = 0; round < ROUNDS && at.has_derivative; round++) {
    memcpy(H, at.H, sizeof(H));
    weight_covariance(P, x_err, model->state_sigma);

    const float root = sqrtf(R);
    const float w    = weight(model->measurement_sigma, at.error / at_least_smallest(root));
    R                = root * root / at_least_smallest(w);

    gain(K, P, H, R);
    for (int i = 0; i < KC_STATE_DIM; i++) {
      x_err[i] = K[i] * prior_error;
      X[i]     = core->S[i] + x_err[i];
    }
    at = model->linearize(X, measurement);
  }
  kalmanCoreUpdateWithPKE(core, H, K, P, prior_error);
}
