#include "builtin/kalman/supervisor.h"

#include <math.h>

cf_kalman_limits_t cf_kalman_default_limits(void) {
  return (cf_kalman_limits_t){.max_position = 100.0f, .max_velocity = 10.0f};
}

static bool exceeds(const float *vector, float limit) {
  return limit > 0.0f &&
         (fabsf(vector[0]) > limit || fabsf(vector[1]) > limit || fabsf(vector[2]) > limit);
}

bool cf_kalman_state_is_within(const kalmanCoreData_t *core, const cf_kalman_limits_t *limits) {
  return !exceeds(&core->S[KC_STATE_X], limits->max_position) &&
         !exceeds(&core->S[KC_STATE_PX], limits->max_velocity);
}
