#include "vehicle/barometer.h"

#include <math.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

static const float SEA_LEVEL   = 101570.0f;          // [Pa]
static const float LAPSE       = 0.0065f / 298.15f;  // [1/m], of the temperature, relative
static const float EXPONENT    = -5.25588f;          // -1 / 0.1902630958
static const float TEMPERATURE = 25.0f;              // [deg C]
static const float TIME_STEPS  = 6000.0f;            // of the drift: 120 s at 50 Hz

cf_status_t cf_barometer_init(cf_barometer_t *barometer, const cf_barometer_config_t *config,
                              cf_random_t random) {
  if (!cf_is_within(config->altitude, -500.0f, 9000.0f) || !cf_is_not_negative(config->noise) ||
      !cf_is_not_negative(config->drift) || !cf_is_within(config->wash_low, -10.0f, 10.0f) ||
      !cf_is_within(config->wash_high, config->wash_low, 10.0f) ||
      !cf_is_positive(config->wash_height) || !cf_is_within(config->noise_scale, 0.0f, 100.0f)) {
    return CF_ERR_VALUE;
  }

  const float share = cf_random_uniform(&random);

  *barometer = (cf_barometer_t){
      .config    = *config,
      .wash      = config->wash_low + share * (config->wash_high - config->wash_low),
      .countdown = CF_BAROMETER_TICKS,
      .random    = random,
  };
  return CF_OK;
}

float cf_pressure_at(float asl) {
  return SEA_LEVEL * powf(1.0f + LAPSE * asl, EXPONENT);
}

bool cf_barometer_step(cf_barometer_t *barometer, float height, float surface, float vibration,
                       float *pressure, float *temperature) {
  if (--barometer->countdown > 0) {
    return false;
  }
  barometer->countdown = CF_BAROMETER_TICKS;

  float normal[2];
  cf_next_normals(&barometer->random, normal, 2);

  // a first-order process that keeps its standard deviation
  const cf_barometer_config_t *config = &barometer->config;
  const float                  kick   = sqrtf(2.0f / TIME_STEPS) * config->drift * normal[1];
  barometer->wander += kick - barometer->wander / TIME_STEPS;

  const float near  = expf(-fmaxf(height - surface, 0.0f) / config->wash_height);
  const float wash  = barometer->wash * vibration * near;
  const float error = config->noise_scale * (wash + barometer->wander + config->noise * normal[0]);
  *pressure         = cf_pressure_at(config->altitude + height + error);
  *temperature      = TEMPERATURE;
  return true;
}
