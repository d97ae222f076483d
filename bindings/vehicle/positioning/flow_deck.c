#include "vehicle/positioning/flow_deck.h"

#include <math.h>

#include "vehicle/random_inline.h"
#include "vehicle/ranger.h"
#include "vehicle/valid.h"

#define RANGE_TICKS 25
#define FLOW_TICKS 10
#define SURFACE_QUALITY 100

static const float TICK             = 0.001f;    // [s]
static const float PIXELS           = 35.0f;     // N, across the field of view
static const float FIELD_OF_VIEW    = 0.71674f;  // 2 sin(42 deg / 2)
static const float COUNTS_PER_PIXEL = 10.0f;
static const float LOWEST_UPRIGHT   = 0.1f;  // R22 of a tilt of 84 deg
static const float LOWEST_MODEL     = 0.1f;  // [m], below it the filter assumes this height
static const float LARGEST_REGISTER = 32767.0f;

// standard deviation [counts] = 0.0007984 shutter + 0.4335 (docs/reference/estimators.md#13.2)
static const float SHUTTER_SLOPE  = 0.0007984f;
static const float SHUTTER_OFFSET = 0.4335f;

cf_status_t cf_flow_deck_init(cf_flow_deck_t *deck, const cf_flow_deck_config_t *config,
                              cf_random_t random, cf_random_t mishap_random) {
  if (!cf_is_within(config->range_noise_scale, 0.0f, 100.0f) ||
      !cf_is_not_negative(config->flow_noise) || cf_mishap_check(&config->range_mishap) != CF_OK ||
      cf_mishap_check(&config->flow_mishap) != CF_OK) {
    return CF_ERR_VALUE;
  }

  *deck = (cf_flow_deck_t){
      .config          = *config,
      .range_countdown = RANGE_TICKS,
      .flow_countdown  = FLOW_TICKS,
      .random          = random,
      .mishap_random   = mishap_random,
  };
  return CF_OK;
}

bool cf_flow_deck_will_look_down(const cf_flow_deck_t *deck) {
  return deck->range_countdown == 1;
}

void cf_flow_deck_look_down(cf_flow_deck_t *deck, const float position[3], const float rotation[9],
                            const cf_surroundings_t *surroundings) {
  const float upright = rotation[8];
  if (!(upright > LOWEST_UPRIGHT)) {
    return;
  }
  const float distance = cf_ranger_look_down(position, rotation, surroundings);
  // over the floor exactly zero: a drone in a swarm flies like one alone, to the last bit
  const bool is_floor = distance == position[2] / upright;
  deck->surface       = is_floor ? 0.0f : position[2] - distance * upright;
}

static uint16_t range_of(cf_flow_deck_t *deck, float height, float upright) {
  const float normal = cf_random_normal(&deck->random);
  const float wrong  = cf_mishap_error(&deck->config.range_mishap, &deck->mishap_random);

  // along body -z; negated, so that NaN meets nothing either
  if (deck->is_lost || !(upright > LOWEST_UPRIGHT)) {
    return CF_RANGE_NOTHING;
  }
  const float true_distance = height / upright;
  return cf_ranger_reading(true_distance, deck->config.range_noise_scale, normal, wrong);
}

// A whole number of counts, negative along the axis of the chip.
static int16_t register_of(float counts) {
  if (!(fabsf(counts) < LARGEST_REGISTER)) {
    return counts < 0.0f ? INT16_MAX : -INT16_MAX;
  }
  return (int16_t)-rintf(counts);
}

static uint16_t shutter_of(float noise) {
  const float shutter = (noise - SHUTTER_OFFSET) / SHUTTER_SLOPE + 0.5f;
  if (!(shutter > 0.0f)) {
    return 0;
  }
  return (uint16_t)fminf(shutter, (float)UINT16_MAX);
}

static void read_flow(cf_flow_deck_t *deck, float height, const float r[9], const float v[3],
                      const float w[3], cf_flow_reading_t *reading) {
  const cf_mishap_config_t *mishap = &deck->config.flow_mishap;
  float                     normal[2];
  cf_next_normals(&deck->random, normal, 2);
  const float wrong[2] = {cf_mishap_error(mishap, &deck->mishap_random),
                          cf_mishap_error(mishap, &deck->mishap_random)};

  // body velocity along x and y
  const float vx = r[0] * v[0] + r[3] * v[1] + r[6] * v[2];
  const float vy = r[1] * v[0] + r[4] * v[1] + r[7] * v[2];

  // counts = 10 k (v_x R22 / z - w_y), 10 k (v_y R22 / z + w_x)
  const float k       = COUNTS_PER_PIXEL * ((float)FLOW_TICKS * TICK) * PIXELS / FIELD_OF_VIEW;
  const float noise   = deck->config.flow_noise;
  const float upright = r[8];
  const float z       = height < LOWEST_MODEL ? LOWEST_MODEL : height;
  const float x       = k * (vx * upright / z - w[1]) + noise * normal[0] + wrong[0];
  const float y       = k * (vy * upright / z + w[0]) + noise * normal[1] + wrong[1];

  // the chip lies turned: its axes are -y and -x of the body
  // On the floor the picture is out of focus, but static, and the chip has to report no motion:
  // with the accelerometer alone the filter is 0.3 m off after 2 s, and cflib's reset_estimator,
  // which runs before a take-off with a flow deck, never returns. What the register holds on the
  // floor is not established.
  const bool is_seen = upright > LOWEST_UPRIGHT && !deck->is_lost;
  reading->delta_x   = register_of(y);
  reading->delta_y   = register_of(x);
  reading->motion    = is_seen ? CF_FLOW_MOTION : CF_FLOW_NO_MOTION;
  reading->squal     = is_seen ? SURFACE_QUALITY : 0;
  reading->shutter   = shutter_of(noise);
}

int cf_flow_deck_step(cf_flow_deck_t *deck, float height, const float rotation[9],
                      const float velocity_world[3], const float rates_body[3],
                      cf_flow_reading_t *reading) {
  int measured = 0;

  if (--deck->range_countdown == 0) {
    deck->range_countdown = RANGE_TICKS;
    reading->range        = range_of(deck, height, rotation[8]);
    measured |=
        cf_mishap_drops(&deck->config.range_mishap, &deck->mishap_random) ? 0 : CF_FLOW_DECK_RANGE;
  }
  if (--deck->flow_countdown == 0) {
    deck->flow_countdown = FLOW_TICKS;
    read_flow(deck, height, rotation, velocity_world, rates_body, reading);
    measured |=
        cf_mishap_drops(&deck->config.flow_mishap, &deck->mishap_random) ? 0 : CF_FLOW_DECK_FLOW;
  }
  return measured;
}
