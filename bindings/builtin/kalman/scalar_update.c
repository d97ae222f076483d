/* P = (K H - I) P (K H - I)' + K r K' (docs/reference/estimators.md#4.6).
 *
 * M = K H - I has entries only on its diagonal and in the columns where H has one. Both products
 * use only those, in the order of k, which keeps the bits (see covariance.h) and saves most of the
 * work: few sensors see more than one to three of the nine states. */
#include "builtin/kalman/scalar_update.h"

#include "builtin/kalman/covariance.h"

// Where H is not zero, in ascending order.
typedef struct {
  int count;
  int at[KC_STATE_DIM];
} entries_t;

static entries_t entries_of(const float Hm[KC_STATE_DIM]) {
  entries_t entries = {.count = 0};
  for (int k = 0; k < KC_STATE_DIM; k++) {
    if (Hm[k] != 0.0f) {
      entries.at[entries.count++] = k;
    }
  }
  return entries;
}

// S += K error
static void correct(kalmanCoreData_t *self, cf_row9_t K, float error) {
  cf_row9_store(self->S, cf_row9_plus(cf_row9_load(self->S), cf_row9_times(K, error)));
}

// Row i of the first product is m_i P_h - P_i, of the second t_i m' - T_i, where m is column h of M
// and t column h of T.
void cf_scalar_update_single(kalmanCoreData_t *core, int h, float H, float error, float std_dev) {
  const cf_row9_t row    = cf_row9_load(core->P[h]);
  const cf_row9_t column = cf_row9_column(core->P, h);
  const float     p_hh   = core->P[h][h];
  const float     r      = std_dev * std_dev;

  // K = P H' / (H P H' + r)
  const float     y_h = p_hh * H;
  const float     s   = r + H * y_h;
  const cf_row9_t K   = cf_row9_over(cf_row9_times(column, H), s);
  correct(core, K, error);

  const cf_row9_t m = cf_row9_with(cf_row9_times(K, H), h, y_h / s * H - 1.0f);
  const cf_row9_t t = cf_row9_minus(cf_row9_times(m, p_hh), cf_row9_with(column, h, 0.0f));
  float           m_of[KC_STATE_DIM];
  float           t_of[KC_STATE_DIM];
  cf_row9_store(m_of, m);
  cf_row9_store(t_of, t);

  // column h has its -1 within m, and so has row h
  cf_row9_t P[KC_STATE_DIM];
  for (int i = 0; i < KC_STATE_DIM; i++) {
    const cf_row9_t T = cf_row9_minus(cf_row9_times(row, m_of[i]), cf_row9_load(core->P[i]));
    P[i]              = cf_row9_minus(cf_row9_times(m, t_of[i]), cf_row9_with(T, h, 0.0f));
  }
  const cf_row9_t T_h = cf_row9_with(cf_row9_times(row, m_of[h]), h, 0.0f);
  P[h]                = cf_row9_minus(cf_row9_times(m, t_of[h]), T_h);

  cf_covariance_bound_plus(core, P, K, r);
  core->isUpdated = true;
}

// Row i of T = M P, where m[u] is column at[u] of M.
static cf_row9_t row_of_first_product(int i, const entries_t *entries,
                                      const float     m[KC_STATE_DIM][KC_STATE_DIM],
                                      const cf_row9_t P[KC_STATE_DIM]) {
  cf_row9_t T   = cf_row9_zero();
  bool      own = false;  // is the -1 of the diagonal taken into account?
  for (int u = 0; u < entries->count; u++) {
    const int k = entries->at[u];
    if (!own && k >= i) {
      T   = k > i ? cf_row9_minus(T, P[i]) : T;
      own = true;
    }
    T = cf_row9_plus(T, cf_row9_times(P[k], m[u][i]));
  }
  return own ? T : cf_row9_minus(T, P[i]);
}

// The same row of T M'.
static cf_row9_t row_of_second_product(cf_row9_t T, const entries_t *entries,
                                       const cf_row9_t m[KC_STATE_DIM]) {
  float t_of[KC_STATE_DIM];
  cf_row9_store(t_of, T);

  cf_row9_t P    = cf_row9_zero();
  int       next = 0;  // columns before have their -1
  for (int u = 0; u < entries->count; u++) {
    const int k = entries->at[u];
    P           = cf_row9_minus(P, cf_row9_between(T, next, k - 1));
    P           = cf_row9_plus(P, cf_row9_times(m[u], t_of[k]));
    next        = k + 1;
  }
  return cf_row9_minus(P, cf_row9_between(T, next, KC_STATE_DIM - 1));
}

// Any number of entries.
static void update_general(kalmanCoreData_t *self, const entries_t *entries,
                           const float Hm[KC_STATE_DIM], float error, float r) {
  // y = P H'
  cf_row9_t y = cf_row9_zero();
  for (int u = 0; u < entries->count; u++) {
    const int k = entries->at[u];
    y           = cf_row9_plus(y, cf_row9_times(cf_row9_column(self->P, k), Hm[k]));
  }
  float y_of[KC_STATE_DIM];
  cf_row9_store(y_of, y);

  // K = y / (H y + r)
  float s = r;
  for (int u = 0; u < entries->count; u++) {
    s += Hm[entries->at[u]] * y_of[entries->at[u]];
  }
  const cf_row9_t K = cf_row9_over(y, s);
  correct(self, K, error);

  // columns of M
  cf_row9_t m[KC_STATE_DIM];
  float     m_of[KC_STATE_DIM][KC_STATE_DIM];
  for (int u = 0; u < entries->count; u++) {
    const int k = entries->at[u];
    m[u]        = cf_row9_with(cf_row9_times(K, Hm[k]), k, y_of[k] / s * Hm[k] - 1.0f);
    cf_row9_store(m_of[u], m[u]);
  }

  cf_row9_t P[KC_STATE_DIM];
  cf_row9_t updated[KC_STATE_DIM];
  cf_covariance_load(P, self);
  for (int i = 0; i < KC_STATE_DIM; i++) {
    const cf_row9_t T = row_of_first_product(i, entries, m_of, P);
    updated[i]        = row_of_second_product(T, entries, m);
  }
  cf_covariance_bound_plus(self, updated, K, r);
  self->isUpdated = true;
}

void kalmanCoreScalarUpdate(kalmanCoreData_t *self, const float Hm[9], float error,
                            float stdMeasNoise) {
  const entries_t entries = entries_of(Hm);
  if (entries.count == 1) {
    const int h = entries.at[0];
    cf_scalar_update_single(self, h, Hm[h], error, stdMeasNoise);
  } else {
    update_general(self, &entries, Hm, error, stdMeasNoise * stdMeasNoise);
  }
}
