#include "vehicle/wind.h"

#include <math.h>

#include "vehicle/valid.h"

static const float PI              = 3.14159265f;
static const float FOOT            = 0.3048f;  // [m]
static const float LOWEST_AIRSPEED = 0.5f;     // [m/s], of the forming filters
static const float LOWEST_HEIGHT   = 3.0f;     // [m], of the model
static const float HIGHEST_HEIGHT  = 304.8f;   // [m]
static const float GUST_LIMIT      = 50.0f;    // [m/s]
static const float GUST_LONGEST    = 3600.0f;  // [s]

enum { ALONG, ACROSS, UP };

cf_status_t cf_wind_init(cf_wind_t *wind, const cf_wind_config_t *config, cf_random_t random) {
  bool is_valid = config->turbulence >= CF_TURBULENCE_NONE &&
                  config->turbulence <= CF_TURBULENCE_DRYDEN &&
                  cf_is_not_negative(config->indoor_deviation) &&
                  cf_is_positive(config->indoor_time) && cf_is_not_negative(config->dryden_speed);
  for (int i = 0; i < 3; i++) {
    is_valid = is_valid && cf_is_within(config->velocity[i], -CF_ANY_SIZE, CF_ANY_SIZE);
  }
  if (!is_valid) {
    return CF_ERR_VALUE;
  }
  *wind = (cf_wind_t){
      .config      = *config,
      .is_changing = config->turbulence != CF_TURBULENCE_NONE,
      .random      = random,
      .velocity    = {config->velocity[0], config->velocity[1], config->velocity[2]},
  };
  return CF_OK;
}

cf_status_t cf_wind_gust(cf_wind_t *wind, const float peak[3], float duration) {
  if (!cf_is_within(duration, 1.0e-3f, GUST_LONGEST)) {
    return CF_ERR_VALUE;
  }
  for (int i = 0; i < 3; i++) {
    if (!cf_is_within(peak[i], -GUST_LIMIT, GUST_LIMIT)) {
      return CF_ERR_VALUE;
    }
  }
  for (int i = 0; i < 3; i++) {
    wind->gust_peak[i] = peak[i];
  }
  wind->gust_duration = duration;
  wind->gust_age      = 0.0f;
  wind->is_changing   = true;
  return CF_OK;
}

// A first-order process that keeps its standard deviation.
static void step_first_order(float *state, float decay, float deviation, float normal) {
  *state = decay * *state + deviation * sqrtf(1.0f - decay * decay) * normal;
}

static void add_indoor(cf_wind_t *wind, float elapsed) {
  const cf_wind_config_t *config = &wind->config;
  const float             decay  = expf(-elapsed / config->indoor_time);
  for (int i = 0; i < 3; i++) {
    const float normal = cf_random_normal(&wind->random);
    step_first_order(&wind->filters[i][0], decay, config->indoor_deviation, normal);
    wind->velocity[i] += wind->filters[i][0];
  }
}

// sigma sqrt(L / (pi V)) (1 + sqrt(3) s / a) / (1 + s / a)^2 with a = V / L, driven by white noise:
// two first-order filters in a row, z1' = -a z1 + noise, z2' = a (z1 - z2), whose outputs are
// scaled such that the noise has a deviation of sigma in the end.
static float step_second_order(float z[2], float a, float elapsed, float sigma, float normal) {
  const float before = z[0];
  const float decay  = expf(-a * elapsed);
  step_first_order(&z[0], decay, sigma * 0.70710678f, normal);
  z[1] = decay * z[1] + (1.0f - decay) * 0.5f * (before + z[0]);
  return 1.7320508f * (z[0] - 0.42264973f * z[1]);
}

static float length2(float x, float y) {
  return sqrtf(x * x + y * y);
}

// MIL-F-8785C below 1000 ft: lengths and deviations from the height and the wind at 20 ft.
static void add_dryden(cf_wind_t *wind, float elapsed, float height, const float velocity[3]) {
  const float *steady = wind->config.velocity;
  const float  low    = height > LOWEST_HEIGHT ? height : LOWEST_HEIGHT;
  const float  h      = low < HIGHEST_HEIGHT ? low : HIGHEST_HEIGHT;
  const float  shape  = 0.177f + 0.000823f * (h / FOOT);

  // along the steady wind, or along x without one
  const float speed  = length2(steady[0], steady[1]);
  const float cosine = speed > 0.0f ? steady[0] / speed : 1.0f;
  const float sine   = speed > 0.0f ? steady[1] / speed : 0.0f;

  const float at_20_feet = wind->config.dryden_speed > 0.0f ? wind->config.dryden_speed : speed;
  const float sigma_up   = 0.1f * at_20_feet;
  const float sigma      = sigma_up / powf(shape, 0.4f);
  const float length_up  = h;
  const float length     = h / powf(shape, 1.2f);

  const float dx       = velocity[0] - steady[0];
  const float dy       = velocity[1] - steady[1];
  const float dz       = velocity[2] - steady[2];
  const float moving   = sqrtf(dx * dx + dy * dy + dz * dz);
  const float airspeed = moving > LOWEST_AIRSPEED ? moving : LOWEST_AIRSPEED;

  float normals[3];
  for (int i = 0; i < 3; i++) {
    normals[i] = cf_random_normal(&wind->random);
  }
  float *along = &wind->filters[ALONG][0];
  step_first_order(along, expf(-elapsed * airspeed / length), sigma, normals[ALONG]);
  const float across =
      step_second_order(wind->filters[ACROSS], airspeed / length, elapsed, sigma, normals[ACROSS]);
  const float up =
      step_second_order(wind->filters[UP], airspeed / length_up, elapsed, sigma_up, normals[UP]);

  wind->velocity[0] += cosine * *along - sine * across;
  wind->velocity[1] += sine * *along + cosine * across;
  wind->velocity[2] += up;
}

static void add_gust(cf_wind_t *wind, float elapsed) {
  wind->gust_age += elapsed;
  if (wind->gust_age >= wind->gust_duration) {
    wind->gust_duration = 0.0f;
    return;
  }
  const float share = 0.5f * (1.0f - cosf(2.0f * PI * wind->gust_age / wind->gust_duration));
  for (int i = 0; i < 3; i++) {
    wind->velocity[i] += share * wind->gust_peak[i];
  }
}

void cf_wind_update(cf_wind_t *wind, float elapsed, float height, const float velocity[3]) {
  if (!wind->is_changing) {
    return;
  }
  for (int i = 0; i < 3; i++) {
    wind->velocity[i] = wind->config.velocity[i];
  }
  if (wind->config.turbulence == CF_TURBULENCE_INDOOR) {
    add_indoor(wind, elapsed);
  } else if (wind->config.turbulence == CF_TURBULENCE_DRYDEN) {
    add_dryden(wind, elapsed, height, velocity);
  }
  if (wind->gust_duration > 0.0f) {
    add_gust(wind, elapsed);
  }
  wind->is_changing = wind->config.turbulence != CF_TURBULENCE_NONE || wind->gust_duration > 0.0f;
}
