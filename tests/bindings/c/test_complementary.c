// The complementary estimator, the barometer and their front end survive whatever they are fed.

#include "builtin/complementary/complementary.h"

#include <math.h>
#include <string.h>

#include "api/quatcompress.h"
#include "check.h"
#include "crazyflie.h"
#include "onboard/compressed.h"
#include "onboard/sensors.h"
#include "vehicle/barometer.h"

static const float HOSTILE[] = {0.0f,      -0.0f,         1.0f,          -1.0f,    1e-45f,
                                -1e-38f,   3.4e38f,       -3.4e38f,      1e20f,    -1e20f,
                                INFINITY,  -INFINITY,     NAN,           32767.0f, 32768.0f,
                                -32769.0f, 2147483647.0f, -2147483648.0f};
#define HOSTILE_COUNT (sizeof HOSTILE / sizeof HOSTILE[0])

static float pick(uint32_t *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return HOSTILE[(*seed >> 16) % HOSTILE_COUNT];
}

static cf_latest_samples_t hostile_samples(uint32_t *seed, uint32_t now_ms) {
  cf_latest_samples_t latest = {.tof  = {.timestamp = now_ms, .distance = pick(seed)},
                                .baro = {.asl = pick(seed)}};
  for (int i = 0; i < 3; i++) {
    latest.gyro.axis[i] = pick(seed);
    latest.acc.axis[i]  = pick(seed);
  }
  return latest;
}

static bool is_finite(const state_t *s) {
  return isfinite(s->attitude.roll + s->attitude.pitch + s->attitude.yaw + s->position.z +
                  s->velocity.z);
}

static void test_estimators_survive_nonsense_and_tell(void) {
  for (int filter = CF_SENSFUSION6_MAHONY; filter <= CF_SENSFUSION6_MADGWICK; filter++) {
    uint32_t seed = 7;
    for (int run = 0; run < 200; run++) {
      cf_complementary_t complementary;
      cf_complementary_boot(&complementary, (cf_sensfusion6_filter_t)filter);
      cf_complementary_init(&complementary);
      state_t estimate = {.position = {.x = 1.0f}};
      for (uint32_t step = 1; step <= 60; step++) {
        const cf_latest_samples_t latest = hostile_samples(&seed, step % 3 == 0 ? step : 0);
        cf_complementary_update(&complementary, &latest, &estimate, step, UINT32_MAX - 30 + step);
      }
      CHECK(estimate.position.x == 0.0f);
    }
  }
}

static void test_good_samples_give_numbers(void) {
  cf_complementary_t complementary;
  cf_complementary_boot(&complementary, CF_SENSFUSION6_MAHONY);
  cf_complementary_init(&complementary);
  const cf_latest_samples_t latest = {.gyro = {.axis = {2000.0f, -2000.0f, 2000.0f}},
                                      .acc  = {.axis = {24.0f, -24.0f, 24.0f}},
                                      .baro = {.asl = 9000.0f}};
  state_t                   estimate;
  memset(&estimate, 0, sizeof estimate);
  for (uint32_t step = 1; step <= 100000; step++) {
    cf_complementary_update(&complementary, &latest, &estimate, step, 2000 + step);
    CHECK(is_finite(&estimate));
  }
}

static void test_compression_survives_nonsense(void) {
  uint32_t seed = 5;
  for (int run = 0; run < 5000; run++) {
    state_t    state;
    setpoint_t setpoint;
    memset(&state, 0, sizeof state);
    memset(&setpoint, 0, sizeof setpoint);
    state.position = (point_t){0, pick(&seed), pick(&seed), pick(&seed)};
    state.acc      = (acc_t){0, pick(&seed), pick(&seed), pick(&seed)};
    state.attitudeQuaternion =
        (quaternion_t){.x = pick(&seed), .y = pick(&seed), .z = pick(&seed), .w = pick(&seed)};
    setpoint.acceleration               = (acc_t){0, pick(&seed), pick(&seed), pick(&seed)};
    const Axis3f                   gyro = {.axis = {pick(&seed), pick(&seed), pick(&seed)}};
    const cf_compressed_state_t    a    = cf_compress_state(&state, &gyro);
    const cf_compressed_setpoint_t b    = cf_compress_setpoint(&setpoint);

    // the same conversion gives the same number
    setpoint.acceleration.x = state.position.x;
    CHECK(cf_compress_setpoint(&setpoint).ax == a.x);
    CHECK(b.x == 0 && b.vz == 0);

    float q[4];
    quatdecompress(a.quat, q);
    CHECK(q[a.quat >> 30] >= 0.0f || isnan(q[a.quat >> 30]));
  }
}

static void test_front_end_survives_nonsense(void) {
  uint32_t seed = 11;
  for (int run = 0; run < 500; run++) {
    cf_sensors_t sensors;
    cf_sensors_init(&sensors);
    cf_sensors_set_trim(&sensors, pick(&seed), pick(&seed));
    const Axis3i16 gyro = {INT16_MIN, INT16_MAX, -1};
    const Axis3i16 acc  = {INT16_MAX, INT16_MIN, 0};
    for (uint32_t tick = 1; tick < 5; tick++) {
      cf_sensors_update(&sensors, &gyro, &acc, tick);
      cf_sensors_update_baro(&sensors, pick(&seed), pick(&seed));
    }
    CHECK(isfinite(sensors.data.gyro.x));
  }
}

static void test_barometer_gives_a_pressure_wherever_a_drone_may_be(void) {
  const float heights[] = {-1e4f, -1.0f, 0.0f, 1e4f};
  for (int k = 0; k < 4; k++) {
    cf_vehicle_config_t config;
    cf_vehicle_t        vehicle;
    CHECK(cf_vehicle_default_config(&config, CF_PLATFORM_CF2) == CF_OK);
    config.barometer.altitude    = k % 2 == 0 ? -500.0f : 9000.0f;
    config.barometer.noise_scale = 100.0f;
    CHECK(cf_vehicle_init(&vehicle, &config, 1, 2) == CF_OK);
    for (int tick = 0; tick < 20000; tick++) {
      float pressure = -1.0f, temperature = -1.0f;
      if (cf_vehicle_barometer(&vehicle, heights[k], &pressure, &temperature)) {
        CHECK(isfinite(pressure) && pressure > 0.0f && temperature == 25.0f);
      } else {
        CHECK(pressure == -1.0f && temperature == -1.0f);
      }
    }
  }
}

static void test_a_drone_whose_attitude_is_no_number_is_stopped(void) {
  static cf_t cf;
  cf_config_t config;
  cf_config_default(&config, CF_PLATFORM_CF2);
  config.vehicle.positioning = CF_POSITIONING_NONE;
  CHECK(cf_init(&cf, &config) == CF_OK);
  const cf_motion_t motion = {.quat_wxyz      = {1, 0, 0, 0},
                              .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                              .specific_force = {0, 0, 9.81f}};
  for (int i = 0; i < 2000; i++) {
    cf_tick(&cf, &motion);
  }
  CHECK(cf.onboard.estimator.type == StateEstimatorTypeComplementary);
  CHECK(cf.onboard.fault == CF_FAULT_NONE);
  cf.onboard.sensors.acc_scale.scale = NAN;
  for (int i = 0; i < 5; i++) {
    cf_tick(&cf, &motion);
  }
  CHECK(cf.onboard.fault == CF_FAULT_ESTIMATE);
}

static void test_every_number_may_be_written_as_estimator(void) {
  static cf_t cf;
  cf_config_t config;
  cf_config_default(&config, CF_PLATFORM_CF2);
  CHECK(cf_init(&cf, &config) == CF_OK);
  const cf_motion_t motion = {.quat_wxyz      = {1, 0, 0, 0},
                              .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                              .specific_force = {0, 0, 9.81f}};
  for (int i = 0; i < 4000; i++) {
    cf.onboard.estimator_type = (uint8_t)i;
    cf_tick(&cf, &motion);
    const int type = cf.onboard.estimator.type;
    CHECK(type == StateEstimatorTypeKalman || type == StateEstimatorTypeComplementary);
    // the loop reads its parameters, from its first iteration on
    CHECK(cf.onboard.step <= 1 || cf.onboard.estimator_type == type);
  }
  CHECK(cf.onboard.fault == CF_FAULT_NONE);
}

int main(void) {
  test_estimators_survive_nonsense_and_tell();
  test_good_samples_give_numbers();
  test_compression_survives_nonsense();
  test_front_end_survives_nonsense();
  test_barometer_gives_a_pressure_wherever_a_drone_may_be();
  test_a_drone_whose_attitude_is_no_number_is_stopped();
  test_every_number_may_be_written_as_estimator();
  return 0;
}
