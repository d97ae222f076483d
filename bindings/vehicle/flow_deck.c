#include "vehicle/flow_deck.h"

#include <math.h>
#include <stdbool.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

#define RANGE_TICKS 25
#define FLOW_TICKS 10

static const float TICK              = 0.001f;    // [s]
static const float PIXELS            = 35.0f;     // N, across the field of view
static const float FIELD_OF_VIEW     = 0.71674f;  // 2 sin(42 deg / 2)
static const float COUNTS_PER_PIXEL  = 10.0f;
static const float LOWEST_UPRIGHT    = 0.1f;    // R22 of a tilt of 84 deg
static const float LONGEST_RANGE     = 5.0f;    // [m]
static const float LARGEST_RANGE_STD = 0.2f;    // [m], what sigma(d) reaches at 4 m
static const float LOWEST_FLOW       = 0.08f;   // [m], out of focus below
static const float LOWEST_MODEL      = 0.1f;    // [m], below it the filter assumes this height
static const float FLOW_OUTLIER      = 100.0f;  // [counts]

cf_status_t cf_flow_deck_init(cf_flow_deck_t *deck, const cf_flow_deck_config_t *config,
                              cf_random_t random) {
  if (!cf_is_within(config->range_noise_scale, 0.0f, 100.0f) ||
      !cf_is_not_negative(config->flow_noise) || !cf_is_positive(config->flow_std)) {
    return CF_ERR_VALUE;
  }

  *deck = (cf_flow_deck_t){
      .config          = *config,
      .range_countdown = RANGE_TICKS,
      .flow_countdown  = FLOW_TICKS,
      .random          = random,
  };
  return CF_OK;
}

float cf_range_std(float distance) {
  // sigma = A (1 + exp(k (d - a))), k = ln(B / A) / (b - a), A = 2.5 mm at a = 2.5 m, B = 0.2 m at
  // b = 4 m
  return 0.0025f * (1.0f + expf(2.92135109f * (distance - 2.5f)));
}

static bool read_range(cf_flow_deck_t *deck, uint32_t tick, float height, float upright,
                       tofMeasurement_t *range) {
  const float normal = cf_random_normal(&deck->random);

  // along body -z; negated, so that NaN gives no reading either
  if (!(upright > LOWEST_UPRIGHT)) {
    return false;
  }
  const float true_distance = height / upright;
  if (!(true_distance < LONGEST_RANGE)) {
    return false;
  }
  const float told        = cf_range_std(true_distance);
  const float deviation   = told < LARGEST_RANGE_STD ? told : LARGEST_RANGE_STD;
  const float noise       = deck->config.range_noise_scale * deviation * normal;
  const float millimeters = (true_distance + noise) * 1000.0f + 0.5f;
  if (!(millimeters < 1000.0f * LONGEST_RANGE)) {
    return false;
  }

  const int   whole    = millimeters > 0.0f ? (int)millimeters : 0;
  const float distance = (float)whole * 0.001f;
  *range               = (tofMeasurement_t){
      .timestamp = tick,
      .distance  = distance,
      .stdDev    = cf_range_std(distance),
  };
  return true;
}

static bool read_flow(cf_flow_deck_t *deck, uint32_t tick, float height, const float r[9],
                      const float v[3], const float w[3], flowMeasurement_t *flow) {
  float normal[2];
  cf_next_normals(&deck->random, normal, 2);
  const float age = (float)deck->flow_age * TICK;

  // body velocity along x and y
  const float vx = r[0] * v[0] + r[3] * v[1] + r[6] * v[2];
  const float vy = r[1] * v[0] + r[4] * v[1] + r[7] * v[2];

  // counts = 10 k (v_x R22 / z - w_y), 10 k (v_y R22 / z + w_x)
  const float k       = COUNTS_PER_PIXEL * ((float)FLOW_TICKS * TICK) * PIXELS / FIELD_OF_VIEW;
  const float upright = r[8];
  const float z       = height < LOWEST_MODEL ? LOWEST_MODEL : height;
  const float x       = rintf(k * (vx * upright / z - w[1]) + deck->config.flow_noise * normal[0]);
  const float y       = rintf(k * (vy * upright / z + w[0]) + deck->config.flow_noise * normal[1]);

  // an outlier is dropped without a trace: the next reading spans its time too
  if (!(fabsf(x) < FLOW_OUTLIER) || !(fabsf(y) < FLOW_OUTLIER)) {
    return false;
  }
  deck->flow_age = 0;
  if (!(height >= LOWEST_FLOW) || !(upright > LOWEST_UPRIGHT)) {
    return false;
  }
  *flow = (flowMeasurement_t){
      .timestamp = tick,
      .dpixel    = {x, y},
      .stdDevX   = deck->config.flow_std,
      .stdDevY   = deck->config.flow_std,
      .dt        = age,
  };
  return true;
}

int cf_flow_deck_step(cf_flow_deck_t *deck, uint32_t tick, float height, const float rotation[9],
                      const float velocity_world[3], const float rates_body[3],
                      tofMeasurement_t *range, flowMeasurement_t *flow) {
  int measured = 0;

  if (--deck->range_countdown == 0) {
    deck->range_countdown = RANGE_TICKS;
    measured |= read_range(deck, tick, height, rotation[8], range) ? CF_FLOW_DECK_RANGE : 0;
  }

  deck->flow_age++;
  if (--deck->flow_countdown == 0) {
    deck->flow_countdown = FLOW_TICKS;
    measured |= read_flow(deck, tick, height, rotation, velocity_world, rates_body, flow)
                    ? CF_FLOW_DECK_FLOW
                    : 0;
  }
  return measured;
}
