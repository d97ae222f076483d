#include "builtin/kalman/kalman.h"

#include <math.h>
#include <string.h>

#include "builtin/kalman/externalize.h"
#include "builtin/kalman/mm_tdoa.h"

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
  outlierFilterTdoaReset(&kalman->tdoa_filter);
  outlierFilterLighthouseReset(&kalman->sweep_filter, 0);
  kalmanCoreInit(&kalman->core, &kalman->params, now_ms);
  keep_attitude(kalman);
}

// The bounds of the covariance replace NaN by 100, and the filter would go on with gains that do
// not follow from its parameters.
static bool is_noise_known(const kalmanCoreParams_t *params) {
  const float sum = params->procNoiseAcc_xy + params->procNoiseAcc_z + params->procNoiseVel +
                    params->procNoisePos + params->procNoiseAtt + params->measNoiseGyro_rollpitch +
                    params->measNoiseGyro_yaw;
  return !isnan(sum);
}

void cf_kalman_predict(cf_kalman_t *kalman, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                       bool is_flying) {
  kalman->is_flying = is_flying;
  kalmanCorePredict(&kalman->core, &kalman->params, acc, gyro, now_ms, is_flying);
  if (!is_noise_known(&kalman->params)) {
    kalman->core.S[KC_STATE_X] = NAN;
  }
}

void cf_kalman_add_process_noise(cf_kalman_t *kalman, uint32_t now_ms) {
  kalmanCoreAddProcessNoise(&kalman->core, &kalman->params, now_ms);
}

static void update_with_tdoa(cf_kalman_t *kalman, const tdoaMeasurement_t *tdoa, uint32_t now_ms) {
  if (kalman->robust_tdoa) {
    kalmanCoreRobustUpdateWithTdoa(&kalman->core, tdoa, &kalman->tdoa_filter,
                                   kalman->robust_tdoa_error);
  } else {
    kalman->tdoa_innovation = cf_mm_tdoa_update(&kalman->core, tdoa, now_ms, &kalman->tdoa_filter);
  }
}

static void update_with_distance(cf_kalman_t *kalman, const distanceMeasurement_t *distance) {
  if (kalman->robust_twr) {
    kalmanCoreRobustUpdateWithDistance(&kalman->core, distance, kalman->robust_distance_error);
  } else {
    kalmanCoreUpdateWithDistance(&kalman->core, distance);
  }
}

static void update_with_sweep_angle(cf_kalman_t *kalman, const sweepAngleMeasurement_t *sweep,
                                    uint32_t now_ms) {
  // lighthouse code that has geometry and calibration of the base station fills the pointers;
  // without them the filter cannot predict the angle
  if (sweep->sensorPos && sweep->rotorPos && sweep->rotorRot && sweep->rotorRotInv &&
      sweep->calib && sweep->calibrationMeasurementModel) {
    kalmanCoreUpdateWithSweepAngles(&kalman->core, sweep, now_ms, &kalman->sweep_filter);
  }
}

static void update_with_barometer(cf_kalman_t *kalman, const baro_t *baro) {
  if (kalman->fuses_barometer) {
    kalmanCoreUpdateWithBaro(&kalman->core, &kalman->params, baro->asl, kalman->is_flying);
  }
}

void cf_kalman_update(cf_kalman_t *kalman, const measurement_t *measurement,
                      const Axis3f *gyro_latest, uint32_t now_ms) {
  switch (measurement->type) {
    case MeasurementTypeTDOA:
      update_with_tdoa(kalman, &measurement->data.tdoa, now_ms);
      break;
    case MeasurementTypePosition:
      kalmanCoreUpdateWithPosition(&kalman->core, &measurement->data.position);
      break;
    case MeasurementTypePose:
      kalmanCoreUpdateWithPose(&kalman->core, &measurement->data.pose);
      break;
    case MeasurementTypeDistance:
      update_with_distance(kalman, &measurement->data.distance);
      break;
    case MeasurementTypeTOF:
      kalmanCoreUpdateWithTof(&kalman->core, &measurement->data.tof);
      break;
    case MeasurementTypeAbsoluteHeight:
      kalmanCoreUpdateWithAbsoluteHeight(&kalman->core, &measurement->data.height);
      break;
    case MeasurementTypeFlow:
      cf_mm_flow_update(&kalman->core, &measurement->data.flow, gyro_latest, &kalman->flow_position,
                        &kalman->flow);
      break;
    case MeasurementTypeYawError:
      kalmanCoreUpdateWithYawError(&kalman->core, &measurement->data.yawError);
      break;
    case MeasurementTypeSweepAngle:
      update_with_sweep_angle(kalman, &measurement->data.sweepAngle, now_ms);
      break;
    case MeasurementTypeBarometer:
      update_with_barometer(kalman, &measurement->data.barometer.baro);
      break;
    default:
      // inertial samples belong to the task
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
