#include "vehicle/downwash.h"

#include <math.h>

#include "vehicle/valid.h"

static const float MASS_OF_THE_FIT = 0.034f;  // [kg]
static const float GRAVITY         = 9.81f;   // [m/s^2]

cf_status_t cf_downwash_check(const cf_downwash_config_t *config) {
  // the width stays positive down to the end of the reach
  const bool is_valid = cf_is_not_negative(config->peak) && cf_is_not_negative(config->height) &&
                        cf_is_positive(config->depth) && cf_is_positive(config->width) &&
                        cf_is_not_negative(config->narrowing) &&
                        config->width > config->narrowing * CF_DOWNWASH_REACH_DOWN;
  return is_valid ? CF_OK : CF_ERR_VALUE;
}

float cf_downwash_strength(float mass, float thrust) {
  return sqrtf(mass / MASS_OF_THE_FIT) * (thrust / (mass * GRAVITY));
}

float cf_downwash_force(const cf_downwash_config_t *config, const float offset[3], float strength) {
  const float above = offset[2];
  const float r2    = offset[0] * offset[0] + offset[1] * offset[1];
  // false for NaN
  if (!(above > 0.0f && above <= CF_DOWNWASH_REACH_DOWN &&
        r2 <= CF_DOWNWASH_REACH_ASIDE * CF_DOWNWASH_REACH_ASIDE)) {
    return 0.0f;
  }
  const float width = config->width - config->narrowing * above;
  const float along = (above - config->height) / config->depth;
  return config->peak * strength * expf(-along * along - 0.5f * r2 / (width * width));
}
