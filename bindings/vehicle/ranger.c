#include "vehicle/ranger.h"

#include <math.h>

#define RANGER_ID ((uint64_t)1 << 32)  // drones have ids of 32 bits

static const float LONGEST_RANGE     = 5.0f;      // [m]
static const float LARGEST_RANGE_STD = 0.2f;      // [m], what sigma(d) reaches at 4 m
static const float CONE              = 0.97237f;  // cosine of half of 27 deg
static const float RAY               = 1.0f;

// Axis of the body, and on which side.
static const struct {
  int   axis;
  float sign;
} DIRECTIONS[CF_RANGE_COUNT] = {
    [CF_RANGE_FRONT] = {0, 1.0f}, [CF_RANGE_BACK] = {0, -1.0f},  [CF_RANGE_UP] = {2, 1.0f},
    [CF_RANGE_LEFT] = {1, 1.0f},  [CF_RANGE_RIGHT] = {1, -1.0f}, [CF_RANGE_DOWN] = {2, -1.0f},
};

void cf_rangers_init(cf_rangers_t *rangers, const cf_rangers_config_t *config, float noise_scale,
                     const cf_mishap_config_t *mishap, uint64_t seed, uint64_t id) {
  *rangers = (cf_rangers_t){
      .fitted                = *config,
      .noise_scale           = noise_scale,
      .mishap                = *mishap,
      .multiranger_countdown = CF_MULTIRANGER_TICKS,
      .zranger_countdown     = CF_ZRANGER_TICKS,
  };
  // dice of their own: fitting a deck leaves the noise of everything else as it was
  cf_random_init(&rangers->random, seed, id + RANGER_ID);
  rangers->mishap_random = cf_random_split(&rangers->random);
}

uint16_t cf_ranger_reading(float distance, float noise_scale, float normal, float wrong) {
  // negated, so that NaN meets nothing either
  if (!(distance < LONGEST_RANGE)) {
    return CF_RANGE_NOTHING;
  }
  const float told        = cf_range_std(distance);
  const float deviation   = told < LARGEST_RANGE_STD ? told : LARGEST_RANGE_STD;
  const float noise       = noise_scale * deviation * normal;
  const float millimeters = (distance + noise + wrong) * 1000.0f + 0.5f;
  if (!(millimeters < 1000.0f * LONGEST_RANGE)) {
    return CF_RANGE_NOTHING;
  }
  return (uint16_t)fmaxf(millimeters, 0.0f);
}

static float look(int direction, const float position[3], const float rotation[9],
                  const cf_surroundings_t *surroundings) {
  const int   axis    = DIRECTIONS[direction].axis;
  const float sign    = DIRECTIONS[direction].sign;
  const float unit[3] = {sign * rotation[axis], sign * rotation[3 + axis],
                         sign * rotation[6 + axis]};
  const float cone    = direction == CF_RANGE_DOWN ? RAY : CONE;
  return cf_look(surroundings, position, unit, cone, CF_RANGER_REACH);
}

float cf_ranger_look_down(const float position[3], const float rotation[9],
                          const cf_surroundings_t *surroundings) {
  return look(CF_RANGE_DOWN, position, rotation, surroundings);
}

// Reads one chip. Returns its bit, or 0 when the reading is lost.
static int measure(cf_rangers_t *rangers, int direction, const float position[3],
                   const float rotation[9], const cf_surroundings_t *surroundings,
                   uint16_t *reading) {
  const float distance = look(direction, position, rotation, surroundings);
  const float normal   = cf_random_normal(&rangers->random);
  const float wrong    = cf_mishap_error(&rangers->mishap, &rangers->mishap_random);
  *reading             = cf_ranger_reading(distance, rangers->noise_scale, normal, wrong);
  return cf_mishap_drops(&rangers->mishap, &rangers->mishap_random) ? 0 : 1 << direction;
}

int cf_rangers_step(cf_rangers_t *rangers, const float position[3], const float rotation[9],
                    const cf_surroundings_t *surroundings, uint16_t readings[CF_RANGE_COUNT]) {
  int measured = 0;
  if (rangers->fitted.has_multiranger && --rangers->multiranger_countdown == 0) {
    rangers->multiranger_countdown = CF_MULTIRANGER_TICKS;
    for (int direction = CF_RANGE_FRONT; direction < CF_RANGE_DOWN; direction++) {
      measured |=
          measure(rangers, direction, position, rotation, surroundings, &readings[direction]);
    }
  }
  if (rangers->fitted.has_zranger && --rangers->zranger_countdown == 0) {
    rangers->zranger_countdown = CF_ZRANGER_TICKS;
    measured |=
        measure(rangers, CF_RANGE_DOWN, position, rotation, surroundings, &readings[CF_RANGE_DOWN]);
  }
  return measured;
}
