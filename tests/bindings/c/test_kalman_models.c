/* The measurement models beyond pose, flow and range, and their outlier filters, under sanitizers:
 * no number of a measurement, of a state or of what a model remembers may do harm to memory, and
 * what NaN does is known. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "api/kalman_core.h"
#include "api/lighthouse_calibration.h"
#include "builtin/kalman/kalman.h"
#include "check.h"
#include "hostile_kalman.h"

#define ROUNDS 20000

static const mat3d IDENTITY = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};

static void fill(float *numbers, int count, uint32_t *seed) {
  for (int i = 0; i < count; i++) {
    numbers[i] = hostile(seed);
  }
}

static tdoaMeasurement_t hostile_tdoa(uint32_t *seed) {
  tdoaMeasurement_t tdoa = {.distanceDiff = hostile(seed), .stdDev = hostile(seed)};
  for (int i = 0; i < 2; i++) {
    tdoa.anchorPositions[i] = (point_t){.x = hostile(seed), .y = hostile(seed), .z = hostile(seed)};
  }
  return tdoa;
}

static distanceMeasurement_t hostile_distance(uint32_t *seed) {
  distanceMeasurement_t distance = {.distance = hostile(seed), .stdDev = hostile(seed)};
  fill(distance.pos, 3, seed);
  return distance;
}

// A filter after its first millisecond.
static kalmanCoreData_t sane_core(void) {
  kalmanCoreParams_t params;
  kalmanCoreData_t   core;
  kalmanCoreDefaultParams(&params);
  kalmanCoreInit(&core, &params, 0);
  kalmanCoreAddProcessNoise(&core, &params, 1);
  core.S[KC_STATE_Z] = 1.0f;
  return core;
}

// A filter whose state, and one entry of the covariance, are lost.
static kalmanCoreData_t lost_core(uint32_t *seed) {
  kalmanCoreData_t core = sane_core();
  fill(core.S, KC_STATE_DIM, seed);
  core.P[next(seed) % KC_STATE_DIM][next(seed) % KC_STATE_DIM] = hostile(seed);
  return core;
}

static bool is_finite(const float *numbers, int count) {
  for (int i = 0; i < count; i++) {
    if (!isfinite(numbers[i])) {
      return false;
    }
  }
  return true;
}

static void test_models_of_one_state_take_anything(void) {
  uint32_t seed = 1;
  for (int round = 0; round < ROUNDS; round++) {
    kalmanCoreParams_t params;
    kalmanCoreDefaultParams(&params);
    params.measNoiseBaro     = hostile(&seed);
    kalmanCoreData_t core    = lost_core(&seed);
    core.baroReferenceHeight = hostile(&seed);

    kalmanCoreUpdateWithBaro(&core, &params, hostile(&seed), next(&seed) % 2 == 0);
    covariance_is_bounded(&core);
    const heightMeasurement_t height = {.height = hostile(&seed), .stdDev = hostile(&seed)};
    kalmanCoreUpdateWithAbsoluteHeight(&core, &height);
    covariance_is_bounded(&core);
    const yawErrorMeasurement_t yaw = {.yawError = hostile(&seed), .stdDev = hostile(&seed)};
    kalmanCoreUpdateWithYawError(&core, &yaw);
    covariance_is_bounded(&core);
  }
}

static void test_models_of_anchors_take_anything(void) {
  uint32_t seed = 2;
  for (int round = 0; round < ROUNDS; round++) {
    OutlierFilterTdoaState_t filter;
    outlierFilterTdoaReset(&filter);
    float remembered[2][9];
    fill(&remembered[0][0], 18, &seed);
    const distanceMeasurement_t distance = hostile_distance(&seed);
    const tdoaMeasurement_t     tdoa     = hostile_tdoa(&seed);

    kalmanCoreData_t core = round % 2 == 0 ? sane_core() : lost_core(&seed);
    kalmanCoreUpdateWithDistance(&core, &distance);
    covariance_is_bounded(&core);
    kalmanCoreUpdateWithTdoa(&core, &tdoa, next(&seed), &filter);
    covariance_is_bounded(&core);
    kalmanCoreRobustUpdateWithDistance(&core, &distance, remembered[0]);
    covariance_is_bounded(&core);
    kalmanCoreRobustUpdateWithTdoa(&core, &tdoa, &filter, remembered[1]);
    covariance_is_bounded(&core);
    CHECK(filter.integrator >= 0.0f && filter.integrator <= 300.0f);
  }
}

static void test_weighted_update_takes_anything(void) {
  uint32_t seed = 3;
  for (int round = 0; round < ROUNDS; round++) {
    float H[9];
    float K[9];
    float P_w[9][9];
    fill(H, 9, &seed);
    fill(K, 9, &seed);
    fill(&P_w[0][0], 81, &seed);
    kalmanCoreData_t core = lost_core(&seed);
    kalmanCoreUpdateWithPKE(&core, H, K, P_w, hostile(&seed));
    covariance_is_bounded(&core);
    CHECK(core.isUpdated);
  }
}

static void test_sweeps_take_anything(void) {
  uint32_t seed = 4;
  for (int round = 0; round < ROUNDS; round++) {
    lighthouseCalibrationSweep_t calibration;
    vec3d                        sensor;
    vec3d                        rotor;
    mat3d                        rotation;
    mat3d                        inverse;
    fill(&calibration.phase, 7, &seed);
    fill(sensor, 3, &seed);
    fill(rotor, 3, &seed);
    fill(&rotation[0][0], 9, &seed);
    fill(&inverse[0][0], 9, &seed);
    const sweepAngleMeasurement_t sweep = {
        .sensorPos                   = &sensor,
        .rotorPos                    = &rotor,
        .rotorRot                    = &rotation,
        .rotorRotInv                 = &inverse,
        .t                           = hostile(&seed),
        .measuredSweepAngle          = hostile(&seed),
        .stdDev                      = hostile(&seed),
        .calib                       = &calibration,
        .calibrationMeasurementModel = lighthouseCalibrationMeasurementModelLh2,
    };

    OutlierFilterLhState_t filter;
    outlierFilterLighthouseReset(&filter, next(&seed));
    kalmanCoreData_t core = sane_core();
    kalmanCoreUpdateWithSweepAngles(&core, &sweep, next(&seed), &filter);
    covariance_is_bounded(&core);
    core           = lost_core(&seed);
    core.isUpdated = false;
    kalmanCoreUpdateWithSweepAngles(&core, &sweep, next(&seed), &filter);
    if (core.isUpdated) {
      covariance_is_bounded(&core);
    }
    CHECK(filter.openingWindowMs >= -16 && filter.openingWindowMs <= 40);
  }
}

static void test_sweeps_survive_the_wrap_of_the_clock(void) {
  OutlierFilterLhState_t filter;
  outlierFilterLighthouseReset(&filter, 0);
  CHECK(outlierFilterLighthouseValidateSweep(&filter, 1.0f, 1.0f, 3));
  CHECK(filter.openingTimeMs == UINT32_MAX - 12);
  CHECK(outlierFilterLighthouseValidateSweep(&filter, 1.0f, 0.0f, UINT32_MAX));
}

// A lost innovation spoils the state and spares the covariance, as in every scalar update.
static void test_nan_distance_shows_in_the_state(void) {
  kalmanCoreData_t            core     = sane_core();
  const distanceMeasurement_t distance = {.x = 2.0f, .distance = NAN, .stdDev = 0.25f};
  kalmanCoreUpdateWithDistance(&core, &distance);
  CHECK(isnan(core.S[KC_STATE_X]) && isnan(core.S[KC_STATE_D2]));
  CHECK(core.P[KC_STATE_X][KC_STATE_X] < 1.0f);
}

static void test_nan_differences_are_impossible_ones(void) {
  OutlierFilterTdoaState_t filter;
  outlierFilterTdoaReset(&filter);
  kalmanCoreData_t        core = sane_core();
  const tdoaMeasurement_t tdoa = {
      .anchorPositionA = {.x = 2.0f}, .anchorPositionB = {.y = 2.0f}, .distanceDiff = NAN};
  kalmanCoreUpdateWithTdoa(&core, &tdoa, 1, &filter);
  CHECK(is_finite(core.S, KC_STATE_DIM) && !core.isUpdated);
}

// The robust models ask no filter, and remember: as in the firmware only a boot helps.
static void test_nan_in_a_robust_model_stays_over_a_reset(void) {
  cf_kalman_t kalman;
  cf_kalman_boot(&kalman, 0);
  kalman.robust_twr         = 1;
  const Axis3f  gyro        = {.x = 0.0f, .y = 0.0f, .z = 0.0f};
  measurement_t measurement = {.type = MeasurementTypeDistance};
  measurement.data.distance = (distanceMeasurement_t){.x = 2.0f, .distance = NAN, .stdDev = 0.25f};
  cf_kalman_add_process_noise(&kalman, 1);
  cf_kalman_update(&kalman, &measurement, &gyro, 1);
  CHECK(isnan(kalman.core.S[KC_STATE_X]));
  covariance_is_bounded(&kalman.core);

  measurement.data.distance.distance = 2.0f;
  cf_kalman_init(&kalman, 2);
  cf_kalman_add_process_noise(&kalman, 3);
  cf_kalman_update(&kalman, &measurement, &gyro, 3);
  CHECK(isnan(kalman.core.S[KC_STATE_X]));

  cf_kalman_boot(&kalman, 4);
  kalman.robust_twr = 1;
  cf_kalman_add_process_noise(&kalman, 5);
  cf_kalman_update(&kalman, &measurement, &gyro, 5);
  CHECK(is_finite(kalman.core.S, KC_STATE_DIM));
}

static void test_a_sweep_without_pointers_is_ignored(void) {
  const vec3d                        zero  = {0.0f, 0.0f, 0.0f};
  const lighthouseCalibrationSweep_t ideal = {0};
  const Axis3f                       gyro  = {.x = 0.0f, .y = 0.0f, .z = 0.0f};
  const sweepAngleMeasurement_t      whole = {
      .sensorPos                   = &zero,
      .rotorPos                    = &zero,
      .rotorRot                    = &IDENTITY,
      .rotorRotInv                 = &IDENTITY,
      .stdDev                      = 0.001f,
      .calib                       = &ideal,
      .calibrationMeasurementModel = lighthouseCalibrationMeasurementModelLh2,
  };

  cf_kalman_t kalman;
  cf_kalman_boot(&kalman, 0);
  cf_kalman_t before;
  memcpy(&before, &kalman, sizeof(before));
  for (int missing = 0; missing < 6; missing++) {
    measurement_t            measurement = {.type = MeasurementTypeSweepAngle};
    sweepAngleMeasurement_t *sweep       = &measurement.data.sweepAngle;
    *sweep                               = whole;
    sweep->sensorPos                     = missing == 0 ? NULL : sweep->sensorPos;
    sweep->rotorPos                      = missing == 1 ? NULL : sweep->rotorPos;
    sweep->rotorRot                      = missing == 2 ? NULL : sweep->rotorRot;
    sweep->rotorRotInv                   = missing == 3 ? NULL : sweep->rotorRotInv;
    sweep->calib                         = missing == 4 ? NULL : sweep->calib;
    sweep->calibrationMeasurementModel   = missing == 5 ? NULL : sweep->calibrationMeasurementModel;
    cf_kalman_update(&kalman, &measurement, &gyro, 1);
    CHECK(memcmp(&kalman, &before, sizeof(kalman)) == 0);
  }
}

int main(void) {
  test_models_of_one_state_take_anything();
  test_models_of_anchors_take_anything();
  test_weighted_update_takes_anything();
  test_sweeps_take_anything();
  test_sweeps_survive_the_wrap_of_the_clock();
  test_nan_distance_shows_in_the_state();
  test_nan_differences_are_impossible_ones();
  test_nan_in_a_robust_model_stays_over_a_reset();
  test_a_sweep_without_pointers_is_ignored();
  return 0;
}
