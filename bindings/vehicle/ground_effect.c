#include "vehicle/ground_effect.h"

#include <math.h>

#include "vehicle/valid.h"

static const float REACH       = 1.0f;  // [m], there the gain is 1.0004
static const float LEAST_TILT  = 0.5f;  // cosine of 60 degrees
static const float MOST_FACTOR = 0.9f;  // keeps the denominator positive whatever the geometry

cf_status_t cf_ground_effect_init(cf_ground_effect_t              *effect,
                                  const cf_ground_effect_config_t *config,
                                  const cf_rotors_config_t        *rotors) {
  if (!cf_is_not_negative(config->body) || !cf_is_within(config->cap, 1.0f, CF_ANY_SIZE) ||
      !cf_is_positive(config->lowest_height) || !cf_is_positive(rotors->radius)) {
    return CF_ERR_VALUE;
  }
  const float x = rotors->arm_x;
  const float y = rotors->arm_y;
  const float h = rotors->height;
  *effect       = (cf_ground_effect_t){
      .config    = *config,
      .radius2   = rotors->radius * rotors->radius,
      .distance2 = 4.0f * x * y,
      .diagonal2 = 4.0f * (x * x + y * y),
      .position  = {{x, -x, -x, x}, {-y, -y, y, y}, {h, h, h, h}},
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
  const float gain     = 1.0f / (1.0f - (sum < MOST_FACTOR ? sum : MOST_FACTOR));
  return gain < config->cap ? gain : config->cap;
}

void cf_ground_effect_update(cf_ground_effect_t *effect, float height, const float rotation[9]) {
  // false for NaN
  const bool is_near = height < REACH && rotation[8] > LEAST_TILT;
  for (int i = 0; i < CF_ROTOR_COUNT; i++) {
    const float above = rotation[6] * effect->position[0][i] +
                        rotation[7] * effect->position[1][i] + rotation[8] * effect->position[2][i];
    effect->gain[i]   = is_near ? gain_at(effect, height + above) : 1.0f;
  }
}
