#include "bitcraze/adapter.h"

#include <math.h>

#include "bitcraze/conversions.h"

#if CF_WITH_KALMAN_SUPERVISOR
#include "kalman_supervisor.h"
#endif

cf_kalman_task_t cf_kalman_task = {.max_position = 100.0f, .max_velocity = 10.0f};

static kalmanCoreData_t *const   CORE   = &cf_kalman_task.core;
static kalmanCoreParams_t *const PARAMS = &cf_kalman_task.params;

void cf_kalman_boot(uint32_t now_ms) {
  kalmanCoreDefaultParams(PARAMS);
  cf_kalman_init(NULL, now_ms);
}

void cf_kalman_init(void *state CF_UNUSED, uint32_t now_ms) {
  cf_measurements_reset();
  kalmanCoreInit(CORE, PARAMS, now_ms);
}

// As in the builtin provider: the filter replaces a NaN covariance by 100, and would go on with
// gains that do not follow from its parameters.
static bool is_noise_known(void) {
  const float sum = PARAMS->procNoiseAcc_xy + PARAMS->procNoiseAcc_z + PARAMS->procNoiseVel +
                    PARAMS->procNoisePos + PARAMS->procNoiseAtt + PARAMS->measNoiseGyro_rollpitch +
                    PARAMS->measNoiseGyro_yaw;
  return !isnan(sum);
}

void cf_kalman_predict(void *state CF_UNUSED, const api_Axis3f *acc, const api_Axis3f *gyro,
                       uint32_t now_ms, bool is_flying) {
  Axis3f felt              = cf_checkout_axes(acc);
  Axis3f turning           = cf_checkout_axes(gyro);
  cf_kalman_task.is_flying = is_flying;
#if HAVE_KALMAN_PREDICT_PARAMS
  kalmanCorePredict(CORE, PARAMS, &felt, &turning, now_ms, is_flying);
#else
  kalmanCorePredict(CORE, &felt, &turning, now_ms, is_flying);
#endif
  if (!is_noise_known()) {
    CORE->S[KC_STATE_X] = NAN;
  }
}

void cf_kalman_add_process_noise(void *state CF_UNUSED, uint32_t now_ms) {
  kalmanCoreAddProcessNoise(CORE, PARAMS, now_ms);
}

bool cf_kalman_finalize(void *state CF_UNUSED) {
  return kalmanCoreFinalize(CORE);
}

#if CF_WITH_KALMAN_SUPERVISOR
bool cf_kalman_is_within_bounds(const void *state CF_UNUSED) {
  return kalmanSupervisorIsStateWithinBounds(CORE);
}
#else
static bool exceeds(const float *vector, float limit) {
  return limit > 0.0f &&
         (fabsf(vector[0]) > limit || fabsf(vector[1]) > limit || fabsf(vector[2]) > limit);
}

bool cf_kalman_is_within_bounds(const void *state CF_UNUSED) {
  return !exceeds(&CORE->S[KC_STATE_X], cf_kalman_task.max_position) &&
         !exceeds(&CORE->S[KC_STATE_PX], cf_kalman_task.max_velocity);
}
#endif

void cf_kalman_externalize(const void *state CF_UNUSED, api_state_t *estimate,
                           const api_Axis3f *acc) {
  const Axis3f felt = cf_checkout_axes(acc);
  state_t      is   = {.position = {.x = 0.0f}};
  kalmanCoreExternalizeState(CORE, &is, &felt);
  cf_api_state(estimate, &is);
}

void cf_kalman_disable_attitude_reversion(void *state CF_UNUSED) {
#if HAVE_KALMAN_ATTITUDE_REVERSION
  PARAMS->attitudeReversion = 0.0f;
#endif
}
