#include "vehicle/imu.h"

#include <math.h>
#include <stdbool.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

static const float STEPS_PER_RADIAN_PER_S = 938.734052f;  // 65536 / 4000 * 180 / pi
static const float STEPS_PER_M_PER_S2     = 139.177710f;  // 65536 / 48 / 9.81

static bool is_valid(const cf_imu_config_t *config) {
  return cf_is_not_negative(config->gyro_noise_rest) &&
         cf_is_not_negative(config->gyro_noise_flight) &&
         cf_is_not_negative(config->acc_noise_rest) &&
         cf_is_not_negative(config->acc_noise_flight) && cf_is_not_negative(config->gyro_bias) &&
         cf_is_not_negative(config->acc_bias) &&
         cf_is_within(config->gyro_scale_error, 0.0f, 0.5f) &&
         cf_is_within(config->acc_scale_error, 0.0f, 0.5f) &&
         cf_is_within(config->noise_scale, 0.0f, 100.0f) &&
         cf_is_within(config->bias_scale, 0.0f, 10.0f);
}

// Draws a number within +-limit.
static float error_within(cf_random_t *random, float limit) {
  return limit * (2.0f * cf_random_uniform(random) - 1.0f);
}

static float variance(float deviation, float steps, float scale) {
  return (deviation * steps * scale) * (deviation * steps * scale);
}

cf_status_t cf_imu_init(cf_imu_t *imu, const cf_imu_config_t *config, cf_random_t random) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }

  const float gyro  = STEPS_PER_RADIAN_PER_S;
  const float acc   = STEPS_PER_M_PER_S2;
  const float noise = config->noise_scale;

  *imu = (cf_imu_t){
      .rest_variance   = {variance(config->gyro_noise_rest, gyro, noise),
                          variance(config->acc_noise_rest, acc, noise)},
      .flight_variance = {variance(config->gyro_noise_flight, gyro, noise),
                          variance(config->acc_noise_flight, acc, noise)},
      .random          = random,
  };

  // turn-on errors, always drawn, so that their scale does not change the noise that follows
  for (int i = 0; i < CF_IMU_AXES; i++) {
    const bool  is_gyro = i < 3;
    const float steps   = is_gyro ? gyro : acc;
    const float bias    = config->bias_scale * (is_gyro ? config->gyro_bias : config->acc_bias);
    const float scale =
        config->bias_scale * (is_gyro ? config->gyro_scale_error : config->acc_scale_error);
    imu->bias[i] = steps * error_within(&imu->random, bias);
    imu->gain[i] = steps * (1.0f + error_within(&imu->random, scale));
  }
  return CF_OK;
}

// One reading of one axis, rounded to the nearest step within 16 bits; written so that NaN becomes
// the lowest step.
static inline int16_t reading(const cf_imu_t *imu, int axis, float motion, float sigma,
                              uint64_t bits) {
  const float noise   = sigma * cf_normal_from_bits((uint32_t)bits);
  const float steps   = imu->gain[axis] * motion + imu->bias[axis] + noise;
  const float low     = steps > -32768.0f ? steps : -32768.0f;
  const float clipped = low < 32767.0f ? low : 32767.0f;
  return (int16_t)((int32_t)(clipped + 32768.5f) - 32768);
}

void cf_imu_sample(cf_imu_t *imu, const float rates_body[3], const float specific_force[3],
                   float vibration, Axis3i16 *gyro_raw, Axis3i16 *acc_raw) {
  // independent noises: their variances add
  const float v2         = vibration * vibration;
  const float gyro_sigma = sqrtf(imu->rest_variance[0] + imu->flight_variance[0] * v2);
  const float acc_sigma  = sqrtf(imu->rest_variance[1] + imu->flight_variance[1] * v2);

  // two normal numbers in 64 bits
  const uint64_t x = cf_next_bits(&imu->random);
  const uint64_t y = cf_next_bits(&imu->random);
  const uint64_t z = cf_next_bits(&imu->random);

  gyro_raw->x = reading(imu, 0, rates_body[0], gyro_sigma, x >> 32);
  gyro_raw->y = reading(imu, 1, rates_body[1], gyro_sigma, y >> 32);
  gyro_raw->z = reading(imu, 2, rates_body[2], gyro_sigma, z >> 32);
  acc_raw->x  = reading(imu, 3, specific_force[0], acc_sigma, x);
  acc_raw->y  = reading(imu, 4, specific_force[1], acc_sigma, y);
  acc_raw->z  = reading(imu, 5, specific_force[2], acc_sigma, z);
}
