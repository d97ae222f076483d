#include "builtin/kalman/covariance.h"

#include <math.h>
#include <stdbool.h>

// K r K', the part of it that belongs to a block: kr of its rows, K of its columns.
typedef struct {
  bool        wanted;
  cf_float4_t kr;
  cf_float4_t K;
} noise4_t;

static inline cf_float4_t limit4(cf_float4_t p) {
  const cf_float4_t most = cf_all4(MAX_COVARIANCE);
  return cf_select4(p < most, p, most);
}

// The floor of the diagonal, for element i.
static inline cf_float4_t floor4(cf_float4_t p, int i) {
  cf_float4_t least = cf_all4(-INFINITY);
  least[i]          = MIN_COVARIANCE;
  return cf_select4(p < least, least, p);
}

// out = bounded (x + y') / 2 + noise: two blocks that face each other across the diagonal.
static inline void mean4(cf_float4_t out[4], const cf_float4_t x[4], const cf_float4_t y[4],
                         noise4_t noise) {
  const cf_float4_t half = cf_all4(0.5f);
  cf_float4_t       transposed[4];
  cf_transpose4(transposed, y);

  for (int i = 0; i < 4; i++) {
    cf_float4_t p = half * x[i] + half * transposed[i];
    if (noise.wanted) {
      p += cf_all4(noise.kr[i]) * noise.K;
    }
    out[i] = limit4(p);
  }
}

// A block on the diagonal: its lower triangle repeats the upper one, whose noise rounds as the
// firmware's, and its diagonal has a floor.
static inline void mean4_diagonal(cf_float4_t out[4], const cf_float4_t x[4], noise4_t noise) {
  cf_float4_t upper[4];
  mean4(upper, x, x, noise);

  cf_float4_t lower[4];
  cf_transpose4(lower, upper);
  out[0] = upper[0];
  out[1] = CF_SHUFFLE4(lower[1], upper[1], 0, 5, 6, 7);
  out[2] = CF_SHUFFLE4(lower[2], upper[2], 0, 1, 6, 7);
  out[3] = CF_SHUFFLE4(lower[3], upper[3], 0, 1, 2, 7);

  for (int i = 0; i < 4; i++) {
    out[i] = floor4(out[i], i);
  }
}

static inline void bound(kalmanCoreData_t *core, const cf_row9_t P[KC_STATE_DIM], bool wanted,
                         cf_row9_t K, float r) {
  const cf_row9_t kr = cf_row9_times(K, r);

  // blocks of rows 0 to 3 and 4 to 7
  const cf_float4_t p00[4] = {P[0].a, P[1].a, P[2].a, P[3].a};
  const cf_float4_t p01[4] = {P[0].b, P[1].b, P[2].b, P[3].b};
  const cf_float4_t p10[4] = {P[4].a, P[5].a, P[6].a, P[7].a};
  const cf_float4_t p11[4] = {P[4].b, P[5].b, P[6].b, P[7].b};

  cf_float4_t new00[4];
  cf_float4_t new01[4];
  cf_float4_t new10[4];
  cf_float4_t new11[4];
  mean4_diagonal(new00, p00, (noise4_t){wanted, kr.a, K.a});
  mean4(new01, p01, p10, (noise4_t){wanted, kr.a, K.b});
  cf_transpose4(new10, new01);
  mean4_diagonal(new11, p11, (noise4_t){wanted, kr.b, K.b});

  // row and column 8
  cf_row9_t last = {
      {P[0].c[0], P[1].c[0], P[2].c[0], P[3].c[0]},
      {P[4].c[0], P[5].c[0], P[6].c[0], P[7].c[0]},
      P[8].c,
  };
  last = cf_row9_plus(cf_row9_times(last, 0.5f), cf_row9_times(P[8], 0.5f));
  if (wanted) {
    last = cf_row9_plus(last, cf_row9_times(kr, K.c[0]));
  }
  last = (cf_row9_t){limit4(last.a), limit4(last.b), floor4(limit4(last.c), 0)};

  for (int i = 0; i < 4; i++) {
    cf_row9_store(core->P[i], (cf_row9_t){new00[i], new01[i], cf_all4(last.a[i])});
    cf_row9_store(core->P[4 + i], (cf_row9_t){new10[i], new11[i], cf_all4(last.b[i])});
  }
  cf_row9_store(core->P[8], last);
}

void cf_covariance_bound(kalmanCoreData_t *core, const cf_row9_t P[KC_STATE_DIM]) {
  bound(core, P, false, cf_row9_zero(), 0.0f);
  core->settled = 1;
}

void cf_covariance_bound_plus(kalmanCoreData_t *core, const cf_row9_t P[KC_STATE_DIM], cf_row9_t K,
                              float r) {
  bound(core, P, true, K, r);
  core->settled = 1;
}

// The mean of every entry with itself.
static void bound_symmetric(kalmanCoreData_t *core) {
  float *p = &core->P[0][0];
  for (int n = 0; n < KC_STATE_DIM * KC_STATE_DIM; n++) {
    p[n] = cf_covariance_limit(0.5f * p[n] + 0.5f * p[n]);
  }
  core->settled = 2;
}

void cf_covariance_settle(kalmanCoreData_t *core) {
  if (core->settled == 0) {
    cf_row9_t P[KC_STATE_DIM];
    cf_covariance_load(P, core);
    cf_covariance_bound(core, P);
    return;
  }

  if (core->settled == 1) {
    bound_symmetric(core);
  }
  for (int i = 0; i < KC_STATE_DIM; i++) {
    core->P[i][i] = cf_covariance_limit_diagonal(core->P[i][i]);
  }
}
