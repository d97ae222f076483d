#include "vehicle/positioning/mishap.h"

#include "vehicle/valid.h"

cf_status_t cf_mishap_check(const cf_mishap_config_t *config) {
  const bool is_valid = cf_is_within(config->dropout, 0.0f, 1.0f) &&
                        cf_is_within(config->outlier, 0.0f, 1.0f) &&
                        cf_is_not_negative(config->outlier_size);
  return is_valid ? CF_OK : CF_ERR_VALUE;
}

bool cf_mishap_drops(const cf_mishap_config_t *config, cf_random_t *random) {
  return config->dropout > 0.0f && cf_random_uniform(random) < config->dropout;
}

float cf_mishap_error(const cf_mishap_config_t *config, cf_random_t *random) {
  if (!(config->outlier > 0.0f) || !(cf_random_uniform(random) < config->outlier)) {
    return 0.0f;
  }
  // uniform in -1 to 1, then a quarter away from zero on both sides
  const float u = 2.0f * cf_random_uniform(random) - 1.0f;
  return config->outlier_size * (u < 0.0f ? 0.75f * u - 0.25f : 0.75f * u + 0.25f);
}
