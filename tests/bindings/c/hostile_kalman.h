/* Numbers that break a Kalman filter, and what has to hold of it whatever it was told. */
#ifndef CF_TEST_HOSTILE_KALMAN_H
#define CF_TEST_HOSTILE_KALMAN_H

#include <math.h>
#include <stdint.h>

#include "api/kalman_core.h"
#include "check.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const float HOSTILE[] = {0.0f,   -0.0f,    1e-45f,    -1e-38f, 1e-6f, 1.0f,   -1.0f,
                                0.1f,   -2.5f,    1e10f,     -1e10f,  1e20f, -1e20f, 3e38f,
                                -3e38f, INFINITY, -INFINITY, NAN,     -NAN};

// a small generator, so that the cases are the same everywhere
static inline uint32_t next(uint32_t *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return *seed >> 8;
}

static inline float hostile(uint32_t *seed) {
  return HOSTILE[next(seed) % COUNT(HOSTILE)];
}

static inline void covariance_is_bounded(const kalmanCoreData_t *core) {
  for (int i = 0; i < KC_STATE_DIM; i++) {
    CHECK(core->P[i][i] >= 1e-6f);
    for (int j = 0; j < KC_STATE_DIM; j++) {
      CHECK(core->P[i][j] <= 100.0f);  // NaN fails as well
      CHECK(core->P[i][j] == core->P[j][i]);
    }
  }
}

#endif  // CF_TEST_HOSTILE_KALMAN_H
