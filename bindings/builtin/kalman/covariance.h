/* The covariance between its symmetry and its bounds (docs/reference/estimators.md#4.3). Internal
 * to C.
 *
 * Products of the filter accumulate from k = 0 upward in float32, as the firmware's do, but leave
 * out terms with a factor that is zero by structure. That keeps every finite number: a sum that
 * gains +0 or -0 stays what it was. Only a zero may come out with the other sign, which no later
 * sum, comparison or quotient by a positive number lets through. Infinite entries would differ,
 * where inf * 0 makes a NaN and then 100; they need numbers whose square overflows, and then the
 * estimate is lost either way. */
#ifndef CF_BUILTIN_KALMAN_COVARIANCE_H
#define CF_BUILTIN_KALMAN_COVARIANCE_H

#include "api/kalman_core.h"
#include "builtin/kalman/constants.h"
#include "builtin/kalman/row9.h"

// An entry off the diagonal: 100 in place of NaN and of everything above.
static inline float cf_covariance_limit(float p) {
  return p < MAX_COVARIANCE ? p : MAX_COVARIANCE;
}

// An entry on the diagonal: at least 1e-6, too.
static inline float cf_covariance_limit_diagonal(float p) {
  const float limited = cf_covariance_limit(p);
  return limited < MIN_COVARIANCE ? MIN_COVARIANCE : limited;
}

// Replaces the covariance of the core by the bounded mean of P and its transpose.
void cf_covariance_bound(kalmanCoreData_t *core, const cf_row9_t P[KC_STATE_DIM]);

// The same, with K r K' added to the mean: the end of a scalar update.
void cf_covariance_bound_plus(kalmanCoreData_t *core, const cf_row9_t P[KC_STATE_DIM], cf_row9_t K,
                              float r);

// cf_covariance_bound of the covariance itself, whose diagonal may have grown. Does only what
// `settled` leaves to do. After the first time P is symmetric, and the mean is that of each entry
// with itself. That rounds once more where P is below 2^-125, to an even multiple of the smallest
// float, and never again.
void cf_covariance_settle(kalmanCoreData_t *core);

static inline void cf_covariance_load(cf_row9_t P[KC_STATE_DIM], const kalmanCoreData_t *core) {
  for (int i = 0; i < KC_STATE_DIM; i++) {
    P[i] = cf_row9_load(core->P[i]);
  }
}

#endif  // CF_BUILTIN_KALMAN_COVARIANCE_H
