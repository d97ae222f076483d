#include "vehicle/ground_effect.h"

#include <math.h>

#include "vehicle/valid.h"

static const float REACH      = 1.0f;  // [m], there the gain is 1.0004
static const float MIN_TILT   = 0.5f;  // cosine of 60 degrees
static const float MAX_FACTOR = 0.9f;  // keeps the denominator positive whatever the geometry

cf_status_t cf_ground_effect_init(cf_ground_effect_t              *effect,
                                  const cf_ground_effect_config_t *config,
                                  const cf_rotors_config_t        *rotors) {
  if (!cf_is_not_negative(config->body) || !cf_is_within(config->cap, 1.0f, CF_ANY_SIZE) ||
      !cf_is_positive(config->lowest_height) || !cf_is_positive(rotors->radius)) {
    return CF_ERR_VALUE;
  }
  const float x = rotors->arm_x;
  const float y = rotors->arm_y;
  *effect       = (cf_ground_effect_t){
      .config    = *config,
      .radius2   = rotors->radius * rotors->radius,
      .distance2 = 4.0f * x * y,
      .diagonal2 = 4.0f * (x * x + y * y),
      .gain      = {1.0f, 1.0f, 1.0f, 1.0f},
  };
  return CF_OK;
}

static float pow_minus_1_5(float x) {
  return 1.0f / (x * sqrtf(x));
}

static float gain_at(const cf_ground_effect_t *effect, float height) {
  const cf_ground_effect_config_t *config = &effect->config;

  const float z  = height > config->lowest_height ? height : config->lowest_height;
  const float r2 = effect->radius2;
  const float d2 = effect->distance2;
  const float b2 = effect->diagonal2;
  const float q  = 4.0f * z * z;

  const float single   = 0.25f * r2 / q;
  const float adjacent = z * pow_minus_1_5(d2 + q);
  const float opposite = 0.5f * z * pow_minus_1_5(2.0f * d2 + q);
  const float body     = 2.0f * config->body * z * pow_minus_1_5(b2 + q);
  const float sum      = single + r2 * (adjacent + opposite + body);
  const float gain     = 1.0f / (1.0f - (sum < MAX_FACTOR ? sum : MAX_FACTOR));
  return gain < config->cap ? gain : config->cap;
}

void cf_ground_effect_update(cf_ground_effect_t *effect, const cf_rotors_config_t *rotors,
                             float height, const float rotation[9]) {
  // false for NaN
  if (!(height < REACH && rotation[8] > MIN_TILT)) {
    for (int i = 0; i < CF_ROTOR_COUNT; i++) {
      effect->gain[i] = 1.0f;
    }
    return;
  }
  const float x      = rotation[6] * rotors->arm_x;
  const float y      = rotation[7] * rotors->arm_y;
  const float middle = height + rotation[8] * rotors->height;
  effect->gain[0]    = gain_at(effect, middle + x - y);
  effect->gain[1]    = gain_at(effect, middle - x - y);
  effect->gain[2]    = gain_at(effect, middle - x + y);
  effect->gain[3]    = gain_at(effect, middle + x + y);
}
