#include "attitude_error.h"

#include <stddef.h>

#include "rotation.h"

// Writes R_d' R, by rows.
static void find_turn(const double *wanted, const double *present, double turn[9]) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      turn[3 * i + j] =
          wanted[i] * present[j] + wanted[3 + i] * present[3 + j] + wanted[6 + i] * present[6 + j];
    }
  }
}

void cf_attitude_rates(int count, const cf_attitude_error_t *error, double *rates) {
  for (int i = 0; i < count; i++) {
    const ptrdiff_t of_three = 3 * (ptrdiff_t)i;
    double          present[9], turn[9];
    cf_rotation_of(error->attitudes + 4 * (ptrdiff_t)i, present);
    find_turn(error->wanted + 9 * (ptrdiff_t)i, present, turn);
    const double twice[3] = {turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]};
    for (int j = 0; j < 3; j++) {
      double rate = -0.5 * error->k_r[j] * twice[j];
      if (error->angular != NULL) {
        rate -= error->k_w[j] * error->angular[of_three + j];
      }
      if (error->wanted_rates != NULL) {
        const double *w    = error->wanted_rates + of_three;
        const double  seen = turn[j] * w[0] + turn[3 + j] * w[1] + turn[6 + j] * w[2];
        rate += (1.0 + error->k_w[j]) * seen;
      }
      rates[of_three + j] = rate;
    }
  }
}
