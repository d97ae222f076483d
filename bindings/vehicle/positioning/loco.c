#include "vehicle/positioning/loco.h"

#include <math.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

#define TICKS_PER_SECOND 1000u
#define ANCHORS CF_LOCO_ANCHORS

static const float FARTHEST_ANCHOR = 1000.0f;  // [m]

static bool is_valid(const cf_loco_config_t *config) {
  for (int i = 0; i < ANCHORS; i++) {
    for (int k = 0; k < 3; k++) {
      if (!cf_is_within(config->anchors[i][k], -FARTHEST_ANCHOR, FARTHEST_ANCHOR)) {
        return false;
      }
    }
  }
  return config->twr_rate <= TICKS_PER_SECOND && config->tdoa_rate <= TICKS_PER_SECOND &&
         cf_is_within(config->noise, 0.0f, 100.0f) && cf_is_within(config->bias, 0.0f, 100.0f) &&
         cf_mishap_check(&config->mishap) == CF_OK;
}

cf_status_t cf_loco_init(cf_loco_t *loco, const cf_loco_config_t *config, cf_loco_mode_t mode,
                         cf_random_t random, cf_random_t mishap_random, cf_random_t world) {
  if (!is_valid(config) || mode < CF_LOCO_TWR || mode > CF_LOCO_TDOA3) {
    return CF_ERR_VALUE;
  }
  *loco = (cf_loco_t){
      .config        = *config,
      .mode          = mode,
      .random        = random,
      .mishap_random = mishap_random,
  };
  float normal[ANCHORS];
  cf_next_normals(&world, normal, ANCHORS);
  for (int i = 0; i < ANCHORS; i++) {
    loco->bias[i] = config->bias * normal[i];
  }
  return CF_OK;
}

static bool is_packet_due(cf_loco_t *loco) {
  loco->phase += loco->mode == CF_LOCO_TWR ? loco->config.twr_rate : loco->config.tdoa_rate;
  if (loco->phase < TICKS_PER_SECOND) {
    return false;
  }
  loco->phase -= TICKS_PER_SECOND;
  return true;
}

// Takes the packet of an anchor. Returns false when it is lost.
static bool receive(cf_loco_t *loco, uint32_t anchor, const float position[3]) {
  // drawn even when the packet is lost, so that a loss does not change the noise after it
  const float normal = cf_random_normal(&loco->random);
  if (loco->is_lost || cf_mishap_drops(&loco->config.mishap, &loco->mishap_random)) {
    return false;
  }
  const float *a         = loco->config.anchors[anchor];
  const float  dx        = position[0] - a[0];
  const float  dy        = position[1] - a[1];
  const float  dz        = position[2] - a[2];
  loco->arrivals[anchor] = sqrtf(dx * dx + dy * dy + dz * dz) + loco->bias[anchor] +
                           loco->config.noise * normal +
                           fabsf(cf_mishap_error(&loco->config.mishap, &loco->mishap_random));
  return true;
}

static bool range(cf_loco_t *loco, const float position[3], cf_ranging_t *ranging) {
  const uint8_t anchor = loco->next;
  loco->next           = (uint8_t)((anchor + 1u) % ANCHORS);
  if (!receive(loco, anchor, position)) {
    return false;
  }
  const float distance = loco->arrivals[anchor];
  *ranging             = (cf_ranging_t){
      .mode     = CF_LOCO_TWR,
      .anchor   = anchor,
      .previous = anchor,
      .distance = distance > 0.0f ? distance : 0.0f,
  };
  return true;
}

static void compare(const cf_loco_t *loco, uint8_t previous, uint8_t anchor,
                    cf_ranging_t *ranging) {
  *ranging = (cf_ranging_t){
      .mode     = (uint8_t)loco->mode,
      .anchor   = anchor,
      .previous = previous,
      .distance = loco->arrivals[anchor] - loco->arrivals[previous],
  };
}

static bool compare_in_turn(cf_loco_t *loco, const float position[3], cf_ranging_t *ranging) {
  const uint8_t anchor   = loco->next;
  const uint8_t previous = (uint8_t)((anchor + ANCHORS - 1u) % ANCHORS);
  const bool    has_one  = (loco->heard & (1u << previous)) != 0;
  loco->next             = (uint8_t)((anchor + 1u) % ANCHORS);
  loco->heard            = 0;
  if (!receive(loco, anchor, position)) {
    return false;
  }
  loco->heard = (uint8_t)(1u << anchor);
  if (has_one) {
    compare(loco, previous, anchor, ranging);
  }
  return has_one;
}

static bool compare_at_random(cf_loco_t *loco, const float position[3], cf_ranging_t *ranging) {
  const uint64_t bits     = cf_next_bits(&loco->random);
  const uint32_t anchor   = (uint32_t)(bits >> 32) % ANCHORS;
  const uint32_t previous = (anchor + 1u + (uint32_t)(bits >> 40) % (ANCHORS - 1u)) % ANCHORS;
  if (!receive(loco, anchor, position)) {
    return false;
  }
  loco->heard |= (uint8_t)(1u << anchor);
  const bool has_one = (loco->heard & (1u << previous)) != 0;
  if (has_one) {
    compare(loco, (uint8_t)previous, (uint8_t)anchor, ranging);
  }
  return has_one;
}

bool cf_loco_step(cf_loco_t *loco, const float position[3], cf_ranging_t *ranging) {
  if (!is_packet_due(loco)) {
    return false;
  }
  switch (loco->mode) {
    case CF_LOCO_TDOA2:
      return compare_in_turn(loco, position, ranging);
    case CF_LOCO_TDOA3:
      return compare_at_random(loco, position, ranging);
    default:
      return range(loco, position, ranging);
  }
}
