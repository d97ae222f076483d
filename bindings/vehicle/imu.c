#include "vehicle/imu.h"

#include <math.h>
#include <stdbool.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

#define GYRO 0
#define ACC 1

// The walk of the bias goes in steps of 0.1 s: it is far below a step of the converter by then.
#define WALK_TICKS 100

static const float STEPS_PER_RADIAN_PER_S = 938.734052f;  // 65536 / 4000 * 180 / pi
static const float STEPS_PER_M_PER_S2     = 139.177710f;  // 65536 / 48 / 9.81
static const float NYQUIST                = 500.0f;       // [Hz]
static const float WALK_TIME              = 0.1f;         // [s]
static const float LONGEST_MEMORY         = 0.999f;

static bool is_valid(const cf_imu_config_t *config) {
  return cf_is_not_negative(config->gyro_noise_rest) &&
         cf_is_not_negative(config->gyro_noise_density) &&
         cf_is_not_negative(config->gyro_noise_flight) &&
         cf_is_not_negative(config->acc_noise_rest) &&
         cf_is_not_negative(config->acc_noise_density) &&
         cf_is_not_negative(config->acc_noise_flight) && cf_is_not_negative(config->gyro_bias) &&
         cf_is_not_negative(config->acc_bias) &&
         cf_is_within(config->gyro_scale_error, 0.0f, 0.5f) &&
         cf_is_within(config->acc_scale_error, 0.0f, 0.5f) &&
         cf_is_not_negative(config->gyro_drift) && cf_is_not_negative(config->acc_drift) &&
         cf_is_within(config->drift_time, 1.0f, CF_ANY_SIZE) &&
         cf_is_within(config->noise_scale, 0.0f, 100.0f) &&
         cf_is_within(config->bias_scale, 0.0f, 10.0f);
}

// Draws a number within +-limit.
static float error_within(cf_random_t *random, float limit) {
  return limit * (2.0f * cf_random_uniform(random) - 1.0f);
}

// The chip's noise: x <- a x + b w has the variance b^2 / (1 - a^2) and, seen slowly, a one-sided
// density N with N^2 * 500 Hz = variance * (1 + a) / (1 - a).
static void shape_rest(cf_imu_t *imu, int sensor, float deviation, float density) {
  const float ratio  = deviation > 0.0f ? density * density * NYQUIST / (deviation * deviation) : 1;
  const float memory = ratio > 1.0f ? (ratio - 1.0f) / (ratio + 1.0f) : 0.0f;
  const float a      = memory < LONGEST_MEMORY ? memory : LONGEST_MEMORY;
  imu->rest_memory[sensor]   = a;
  imu->rest_variance[sensor] = deviation * deviation * (1.0f - a * a);
}

static void draw_turn_on_errors(cf_imu_t *imu, const cf_imu_config_t *config) {
  // always drawn, so that their scale does not change the noise that follows
  for (int i = 0; i < CF_IMU_AXES; i++) {
    const bool  is_gyro = i < 3;
    const float steps   = is_gyro ? STEPS_PER_RADIAN_PER_S : STEPS_PER_M_PER_S2;
    const float bias    = config->bias_scale * (is_gyro ? config->gyro_bias : config->acc_bias);
    const float scale =
        config->bias_scale * (is_gyro ? config->gyro_scale_error : config->acc_scale_error);
    imu->turn_on_bias[i] = steps * error_within(&imu->random, bias);
    imu->bias[i]         = imu->turn_on_bias[i];
    imu->gain[i]         = steps * (1.0f + error_within(&imu->random, scale));
  }
}

static float squared(float x) {
  return x * x;
}

cf_status_t cf_imu_init(cf_imu_t *imu, const cf_imu_config_t *config, cf_random_t random) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }
  const float gyro  = STEPS_PER_RADIAN_PER_S;
  const float acc   = STEPS_PER_M_PER_S2;
  const float noise = config->noise_scale;
  const float walk  = config->bias_scale * sqrtf(WALK_TIME);

  cf_imu_t fresh = {
      .flight_variance = {squared(noise * gyro * config->gyro_noise_flight),
                          squared(noise * acc * config->acc_noise_flight)},
      .drift           = {walk * gyro * config->gyro_drift, walk * acc * config->acc_drift},
      .leash           = WALK_TIME / config->drift_time,
      .countdown       = WALK_TICKS,
      .random          = random,
  };
  const cf_status_t status = cf_rotor_vibration_init(&fresh.lines, &config->lines);
  if (status != CF_OK) {
    return status;
  }
  shape_rest(&fresh, GYRO, noise * gyro * config->gyro_noise_rest,
             noise * gyro * config->gyro_noise_density);
  shape_rest(&fresh, ACC, noise * acc * config->acc_noise_rest,
             noise * acc * config->acc_noise_density);
  draw_turn_on_errors(&fresh, config);
  *imu = fresh;
  return CF_OK;
}

float cf_imu_steps(int axis) {
  return axis < 3 ? STEPS_PER_RADIAN_PER_S : STEPS_PER_M_PER_S2;
}

static void walk(cf_imu_t *imu) {
  imu->countdown = WALK_TICKS;
  float normal[CF_IMU_AXES];
  cf_next_normals(&imu->random, normal, CF_IMU_AXES);
  for (int i = 0; i < CF_IMU_AXES; i++) {
    imu->bias[i] += imu->drift[i < 3 ? GYRO : ACC] * normal[i] -
                    imu->leash * (imu->bias[i] - imu->turn_on_bias[i]);
  }
}

// The noise of one sensor at present: y = kept + e, kept <- a y + zero * e, e of this deviation.
typedef struct {
  float memory;     // a
  float zero;       // [-1, 0]
  float deviation;  // [LSB]
} noise_t;

// One pole with drive b^2 and white noise c^2 together have, behind the pole, the covariances
// b^2 + (1 + a^2) c^2 and -a c^2, which s^2 (1 + zero^2) and s^2 zero have to be.
static inline noise_t noise_of(const cf_imu_t *imu, int sensor, float vibration) {
  const float a     = imu->rest_memory[sensor];
  const float drive = imu->rest_variance[sensor];
  const float white = imu->flight_variance[sensor] * vibration * vibration;
  const float now   = drive + (1.0f + a * a) * white;
  const float least = drive + (1.0f - a) * (1.0f - a) * white;
  const float most  = drive + (1.0f + a) * (1.0f + a) * white;
  const float s2    = 0.5f * (now + sqrtf(least * most));
  const float zero  = s2 > 0.0f ? -a * white / s2 : 0.0f;
  return (noise_t){.memory = a, .zero = zero, .deviation = sqrtf(s2)};
}

// One reading of one axis, rounded to the nearest step within 16 bits; written so that NaN becomes
// the lowest step.
static inline int16_t reading(cf_imu_t *imu, int axis, float motion, noise_t noise, uint64_t bits) {
  const float e       = noise.deviation * cf_normal_from_bits((uint32_t)bits);
  const float y       = imu->kept[axis] + e;
  imu->kept[axis]     = noise.memory * y + noise.zero * e;
  const float steps   = imu->gain[axis] * motion + imu->bias[axis] + y;
  const float low     = steps > -32768.0f ? steps : -32768.0f;
  const float clipped = low < 32767.0f ? low : 32767.0f;
  return (int16_t)((int32_t)(clipped + 32768.5f) - 32768);
}

void cf_imu_sample(cf_imu_t *imu, const float rates_body[3], const float specific_force[3],
                   float vibration, Axis3i16 *gyro_raw, Axis3i16 *acc_raw) {
  if (--imu->countdown == 0) {
    walk(imu);
  }
  const noise_t gyro = noise_of(imu, GYRO, vibration);
  const noise_t acc  = noise_of(imu, ACC, vibration);

  // two normal numbers in 64 bits
  const uint64_t x = cf_next_bits(&imu->random);
  const uint64_t y = cf_next_bits(&imu->random);
  const uint64_t z = cf_next_bits(&imu->random);

  gyro_raw->x = reading(imu, 0, rates_body[0], gyro, x >> 32);
  gyro_raw->y = reading(imu, 1, rates_body[1], gyro, y >> 32);
  gyro_raw->z = reading(imu, 2, rates_body[2], gyro, z >> 32);
  acc_raw->x  = reading(imu, 3, specific_force[0], acc, x);
  acc_raw->y  = reading(imu, 4, specific_force[1], acc, y);
  acc_raw->z  = reading(imu, 5, specific_force[2], acc, z);
}
