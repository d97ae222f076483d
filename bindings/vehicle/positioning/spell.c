#include "vehicle/positioning/spell.h"

#include "vehicle/valid.h"

static const float HIGHEST_RATE = 100.0f;  // [1/s]
static const float LONGEST_TIME = 100.0f;  // [s]

cf_status_t cf_spell_check(const cf_spell_config_t *config) {
  const bool is_valid = cf_is_within(config->rate, 0.0f, HIGHEST_RATE) &&
                        cf_is_within(config->time, 0.0f, LONGEST_TIME);
  return is_valid ? CF_OK : CF_ERR_VALUE;
}

bool cf_spell_step(const cf_spell_config_t *config, uint32_t frames, uint32_t *left,
                   cf_random_t *random) {
  if (*left > 0) {
    (*left)--;
  }
  if (*left > 0 || !(config->rate > 0.0f) ||
      !(cf_random_uniform(random) * (float)frames < config->rate)) {
    return false;
  }
  const float seconds = 2.0f * config->time * cf_random_uniform(random);
  *left               = 1u + (uint32_t)(seconds * (float)frames);
  return true;
}
