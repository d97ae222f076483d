/* Loco positioning: eight ultra-wideband anchors tell the drone distances, or differences of them.
 *
 * A packet of an anchor arrives as if the anchor were `bias` and `noise` farther away than it is,
 * and now and then much farther, because something stands in the way (NLOS). Three modes of the air
 * (docs/reference/vehicle.md#10, docs/reference/estimators.md#13.5):
 *   TWR    the drone asks one anchor after the other for the distance;
 *   TDoA2  the anchors speak in turn; each packet is compared with the one just before it;
 *   TDoA3  the anchors speak at random; each packet is compared with the last one of some other. */
#ifndef CF_VEHICLE_POSITIONING_LOCO_H
#define CF_VEHICLE_POSITIONING_LOCO_H

#include <stdbool.h>
#include <stdint.h>

#include "deck_facts.h"
#include "status.h"
#include "vehicle/positioning/mishap.h"
#include "vehicle/random.h"

typedef struct {
  float anchors[CF_LOCO_ANCHORS][3];  // [m], world; at most 1000 m from the origin

  uint32_t twr_rate;   // [Hz], ranges per second, 0 (off) to 1000
  uint32_t tdoa_rate;  // [Hz], packets per second of all anchors, 0 (off) to 1000
  float    noise;      // [m] >= 0, standard deviation of one arrival; of a difference sqrt(2) of it
  float    bias;       // [m] >= 0, standard deviation of the constant error of an anchor

  cf_mishap_config_t mishap;  // of one packet; size in m, always farther
} cf_loco_config_t;

typedef struct {
  cf_loco_config_t config;
  cf_loco_mode_t   mode;
  bool             is_lost;  // while true no packet arrives

  float       bias[CF_LOCO_ANCHORS];      // [m]
  float       arrivals[CF_LOCO_ANCHORS];  // [m], apparent distance when last heard
  uint8_t     heard;                      // bit i: anchor i has been heard; TDoA2: just before
  uint8_t     next;                       // anchor whose turn it is
  uint32_t    phase;                      // [0, 1000), a packet is sent when it wraps
  cf_random_t random;                     // noise, and the order of TDoA3
  cf_random_t mishap_random;              // drop-outs and outliers
} cf_loco_t;

// Fills the system. `world` gives the biases of the anchors: drones that share a room pass equal
// ones. Returns CF_ERR_VALUE when a number of the config is outside its range or `mode` is none of
// TWR, TDoA2 and TDoA3.
cf_status_t cf_loco_init(cf_loco_t *loco, const cf_loco_config_t *config, cf_loco_mode_t mode,
                         cf_random_t random, cf_random_t mishap_random, cf_random_t world);

// Advances by 1 ms with the true position of the deck [m]. Returns true and writes the ranging when
// one is made at this tick.
bool cf_loco_step(cf_loco_t *loco, const float position[3], cf_ranging_t *ranging);

#endif  // CF_VEHICLE_POSITIONING_LOCO_H
