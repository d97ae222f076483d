/* The filter and its task under sanitizers, fed with what no sensor should ever say. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "builtin/kalman/kalman.h"
#include "builtin/math/fast_math.h"
#include "check.h"
#include "hostile_kalman.h"
#include "onboard/estimator.h"

static measurement_t hostile_measurement(uint32_t *seed) {
  measurement_t measurement = {.type = (MeasurementType)(next(seed) % 14)};
  const float   x           = hostile(seed);
  const float   y           = hostile(seed);
  const float   z           = hostile(seed);

  switch (measurement.type) {
    case MeasurementTypePosition:
      measurement.data.position =
          (positionMeasurement_t){.x = x, .y = y, .z = z, .stdDev = hostile(seed)};
      break;
    case MeasurementTypePose:
      measurement.data.pose = (poseMeasurement_t){
          .x          = x,
          .y          = y,
          .z          = z,
          .quat       = {.x = hostile(seed), .y = hostile(seed), .z = hostile(seed), .w = x},
          .stdDevPos  = hostile(seed),
          .stdDevQuat = hostile(seed),
      };
      break;
    case MeasurementTypeTOF:
      measurement.data.tof = (tofMeasurement_t){.distance = x, .stdDev = y, .coneHalfAngle = z};
      break;
    case MeasurementTypeFlow:
      measurement.data.flow = (flowMeasurement_t){
          .dpixelx = x, .dpixely = y, .stdDevX = z, .stdDevY = hostile(seed), .dt = hostile(seed)};
      break;
    case MeasurementTypeTDOA:
      measurement.data.tdoa = (tdoaMeasurement_t){
          .anchorPositionA = {.x = x, .y = y, .z = z},
          .anchorPositionB = {.x = hostile(seed), .y = hostile(seed), .z = hostile(seed)},
          .distanceDiff    = hostile(seed),
          .stdDev          = hostile(seed),
      };
      break;
    case MeasurementTypeDistance:
      measurement.data.distance = (distanceMeasurement_t){
          .x = x, .y = y, .z = z, .distance = hostile(seed), .stdDev = hostile(seed)};
      break;
    case MeasurementTypeAbsoluteHeight:
      measurement.data.height = (heightMeasurement_t){.height = x, .stdDev = y};
      break;
    case MeasurementTypeYawError:
      measurement.data.yawError = (yawErrorMeasurement_t){.yawError = x, .stdDev = y};
      break;
    case MeasurementTypeSweepAngle:
      // as it lies in the queue, without its pointers
      measurement.data.sweepAngle =
          (sweepAngleMeasurement_t){.t = x, .measuredSweepAngle = y, .stdDev = z};
      break;
    case MeasurementTypeBarometer:
      measurement.data.barometer.baro = (baro_t){.pressure = x, .temperature = y, .asl = z};
      break;
    case MeasurementTypeGyroscope:
      measurement.data.gyroscope.gyro = (Axis3f){.x = x, .y = y, .z = z};
      break;
    case MeasurementTypeAcceleration:
      measurement.data.acceleration.acc = (Axis3f){.x = x, .y = y, .z = z};
      break;
    default:
      break;
  }
  return measurement;
}

static void test_table_takes_every_float(void) {
  for (uint32_t bits = 0; bits < UINT32_MAX - 65521u; bits += 65521u) {
    float x;
    memcpy(&x, &bits, sizeof(x));
    const float s = cf_fast_sin(x);
    const float c = cf_fast_cos(x);
    CHECK(isfinite(x) ? fabsf(s) <= 1.0f && fabsf(c) <= 1.0f : isnan(s) && isnan(c));
  }
}

static void test_each_measurement_leaves_a_bounded_covariance(void) {
  uint32_t     seed = 1;
  const Axis3f gyro = {.x = 1.0f, .y = 2.0f, .z = 3.0f};

  for (int round = 0; round < 20000; round++) {
    cf_kalman_t kalman;
    cf_kalman_boot(&kalman, 0);
    kalman.fuses_barometer = true;
    kalman.robust_tdoa     = round % 2 == 0;
    kalman.robust_twr      = round % 3 == 0;
    cf_kalman_add_process_noise(&kalman, 1);

    const measurement_t measurement = hostile_measurement(&seed);
    cf_kalman_update(&kalman, &measurement, &gyro, 1);
    covariance_is_bounded(&kalman.core);
    cf_kalman_finalize(&kalman);
    covariance_is_bounded(&kalman.core);
  }
}

static void test_nan_in_the_covariance_becomes_the_largest_variance(void) {
  for (int i = 0; i < KC_STATE_DIM; i++) {
    for (int j = 0; j < KC_STATE_DIM; j++) {
      cf_kalman_t kalman;
      cf_kalman_boot(&kalman, 0);
      kalman.core.P[i][j] = NAN;
      cf_kalman_add_process_noise(&kalman, 1);
      CHECK(kalman.core.P[i][j] == 100.0f && kalman.core.P[j][i] == 100.0f);
      covariance_is_bounded(&kalman.core);
    }
  }
}

static void test_lost_parameters_and_samples_do_no_harm_to_memory(void) {
  uint32_t seed = 2;

  for (int round = 0; round < 20000; round++) {
    cf_kalman_t kalman;
    cf_kalman_boot(&kalman, next(&seed));
    float *params = &kalman.params.stdDevInitialPosition_xy;
    params[next(&seed) % (sizeof(kalman.params) / sizeof(float))] = hostile(&seed);
    cf_kalman_init(&kalman, next(&seed));

    const Axis3f acc  = {.x = hostile(&seed), .y = hostile(&seed), .z = hostile(&seed)};
    const Axis3f gyro = {.x = hostile(&seed), .y = hostile(&seed), .z = hostile(&seed)};
    cf_kalman_predict(&kalman, &acc, &gyro, next(&seed), next(&seed) % 2 == 0);
    cf_kalman_add_process_noise(&kalman, next(&seed));
    CHECK(cf_kalman_finalize(&kalman));
    covariance_is_bounded(&kalman.core);

    state_t estimate;
    cf_kalman_externalize(&kalman, &estimate, &acc);
  }
}

static void kalman_init(void *state, uint32_t now_ms) {
  cf_kalman_init(state, now_ms);
}

static void kalman_predict(void *state, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                           bool is_flying) {
  cf_kalman_predict(state, acc, gyro, now_ms, is_flying);
}

static void kalman_add_process_noise(void *state, uint32_t now_ms) {
  cf_kalman_add_process_noise(state, now_ms);
}

static void kalman_update(void *state, const measurement_t *measurement, const Axis3f *gyro_latest,
                          uint32_t now_ms) {
  cf_kalman_update(state, measurement, gyro_latest, now_ms);
}

static bool kalman_finalize(void *state) {
  return cf_kalman_finalize(state);
}

static bool kalman_is_within_bounds(const void *state) {
  return cf_kalman_is_within_bounds(state);
}

static void kalman_externalize(const void *state, state_t *estimate, const Axis3f *acc) {
  cf_kalman_externalize(state, estimate, acc);
}

static const cf_provider_t PROVIDER = {
    .name                     = "filter",
    .kalman_init              = kalman_init,
    .kalman_predict           = kalman_predict,
    .kalman_add_process_noise = kalman_add_process_noise,
    .kalman_update            = kalman_update,
    .kalman_finalize          = kalman_finalize,
    .kalman_is_within_bounds  = kalman_is_within_bounds,
    .kalman_externalize       = kalman_externalize,
};

static void test_the_task_survives_floods_of_nonsense(void) {
  uint32_t       seed = 3;
  cf_kalman_t    kalman;
  cf_estimator_t estimator;
  cf_kalman_boot(&kalman, 1000);
  cf_estimator_init(&estimator, &PROVIDER, &kalman, StateEstimatorTypeKalman, 1000);

  for (uint32_t now_ms = 1001; now_ms < 6000; now_ms++) {
    const uint32_t offered = next(&seed) % 40;
    for (uint32_t i = 0; i < offered; i++) {
      const measurement_t measurement = hostile_measurement(&seed);
      CHECK(cf_estimator_enqueue(&estimator, &measurement) == (i < CF_ESTIMATOR_QUEUE_SIZE));
    }
    cf_estimator_run(&estimator, &PROVIDER, &kalman, now_ms, now_ms % 3 == 0);
    CHECK(estimator.queue_count == 0);
    covariance_is_bounded(&kalman.core);
  }

  // what the filter lost comes back with a reset
  estimator.resetEstimation = 1;
  cf_estimator_run(&estimator, &PROVIDER, &kalman, 6000, false);
  for (int i = 0; i < KC_STATE_DIM; i++) {
    CHECK(isfinite(kalman.core.S[i]));
  }
  state_t estimate;
  cf_estimator_get(&estimator, &estimate);
  CHECK(isfinite(estimate.position.x) && isfinite(estimate.attitude.yaw));
}

static void test_the_clock_may_wrap(void) {
  cf_kalman_t kalman;
  cf_kalman_boot(&kalman, UINT32_MAX - 1);
  const Axis3f rest = {.x = 0.0f, .y = 0.0f, .z = 9.81f};
  const Axis3f zero = {.x = 0.0f, .y = 0.0f, .z = 0.0f};
  cf_kalman_predict(&kalman, &rest, &zero, 8, false);
  cf_kalman_add_process_noise(&kalman, 8);
  CHECK(kalman.core.lastPredictionMs == 8);
  CHECK(fabsf(kalman.core.S[KC_STATE_PZ]) < 1e-6f);
}

int main(void) {
  test_table_takes_every_float();
  test_each_measurement_leaves_a_bounded_covariance();
  test_nan_in_the_covariance_becomes_the_largest_variance();
  test_lost_parameters_and_samples_do_no_harm_to_memory();
  test_the_task_survives_floods_of_nonsense();
  test_the_clock_may_wrap();
  return 0;
}
