#include "builtin/kalman/kalman.h"

#include <string.h>

#include "builtin/kalman/externalize.h"

static void keep_attitude(cf_kalman_t *kalman) {
  memcpy(kalman->attitude_of, kalman->core.q, sizeof(kalman->attitude_of));
  kalman->attitude = cf_attitude_in_degrees(kalman->core.q);
}

void cf_kalman_boot(cf_kalman_t *kalman, uint32_t now_ms) {
  *kalman = (cf_kalman_t){.limits = cf_kalman_default_limits()};
  kalmanCoreDefaultParams(&kalman->params);
  cf_kalman_init(kalman, now_ms);
}

void cf_kalman_init(cf_kalman_t *kalman, uint32_t now_ms) {
  kalmanCoreInit(&kalman->core, &kalman->params, now_ms);
  keep_attitude(kalman);
}

void cf_kalman_predict(cf_kalman_t *kalman, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                       bool is_flying) {
  kalmanCorePredict(&kalman->core, &kalman->params, acc, gyro, now_ms, is_flying);
}

void cf_kalman_add_process_noise(cf_kalman_t *kalman, uint32_t now_ms) {
  kalmanCoreAddProcessNoise(&kalman->core, &kalman->params, now_ms);
}

void cf_kalman_update(cf_kalman_t *kalman, const measurement_t *measurement,
                      const Axis3f *gyro_latest, uint32_t now_ms) {
  (void)now_ms;  // for outlier filters to come

  switch (measurement->type) {
    case MeasurementTypePosition:
      kalmanCoreUpdateWithPosition(&kalman->core, &measurement->data.position);
      break;
    case MeasurementTypePose:
      kalmanCoreUpdateWithPose(&kalman->core, &measurement->data.pose);
      break;
    case MeasurementTypeTOF:
      kalmanCoreUpdateWithTof(&kalman->core, &measurement->data.tof);
      break;
    case MeasurementTypeFlow:
      cf_mm_flow_update(&kalman->core, &measurement->data.flow, gyro_latest, &kalman->flow_position,
                        &kalman->flow);
      break;
    default:
      // inertial samples belong to the task, and the barometer is not fused
      break;
  }
}

bool cf_kalman_finalize(cf_kalman_t *kalman) {
  if (!kalmanCoreFinalize(&kalman->core)) {
    return false;
  }
  keep_attitude(kalman);
  return true;
}

bool cf_kalman_is_within_bounds(const cf_kalman_t *kalman) {
  return cf_kalman_state_is_within(&kalman->core, &kalman->limits);
}

void cf_kalman_externalize(const cf_kalman_t *kalman, state_t *estimate, const Axis3f *acc_latest) {
  const bool is_known =
      memcmp(kalman->attitude_of, kalman->core.q, sizeof(kalman->attitude_of)) == 0;
  const attitude_t attitude = is_known ? kalman->attitude : cf_attitude_in_degrees(kalman->core.q);
  cf_externalize_state(&kalman->core, attitude, estimate, acc_latest);
}
