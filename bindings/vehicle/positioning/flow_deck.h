/* The flow deck: a VL53L1x looking down at 40 Hz and a PMW3901 counting pixels at 100 Hz.
 *
 * Range: along body -z, whole millimeters (vehicle/ranger.h). Flow: whole counts, the inverse of
 * the filter's model (docs/reference/estimators.md#5.7, #13.1 and #13.2). What is below is taken
 * for level, at the height that the range found last. Readings are the registers of the chips; what
 * the drivers make of them is onboard/decks/flow_driver.h and ranger_driver.h. */
#ifndef CF_VEHICLE_POSITIONING_FLOW_DECK_H
#define CF_VEHICLE_POSITIONING_FLOW_DECK_H

#include <stdbool.h>
#include <stdint.h>

#include "deck_facts.h"
#include "status.h"
#include "surroundings.h"
#include "vehicle/positioning/mishap.h"
#include "vehicle/random.h"

typedef struct {
  float range_noise_scale;  // [0, 100], on the standard deviation sigma(d); 0 = ideal
  float flow_noise;         // [counts] >= 0, standard deviation; the shutter shows it

  cf_mishap_config_t range_mishap;  // of one range; size in m
  cf_mishap_config_t flow_mishap;   // of one flow; size in counts, per axis
} cf_flow_deck_config_t;

typedef struct {
  cf_flow_deck_config_t config;
  bool                  is_lost;  // while true the chips see nothing

  uint32_t    range_countdown;  // [ticks] to the next reading
  uint32_t    flow_countdown;   // [ticks]
  float       surface;          // [m, world], height of what is below
  cf_random_t random;           // noise
  cf_random_t mishap_random;    // drop-outs and outliers
} cf_flow_deck_t;

// Fills the deck; the first readings come after one period. Returns CF_ERR_VALUE when a number of
// the config is outside its range.
cf_status_t cf_flow_deck_init(cf_flow_deck_t *deck, const cf_flow_deck_config_t *config,
                              cf_random_t random, cf_random_t mishap_random);

// Whether the next step measures the range, and has to know what is below.
bool cf_flow_deck_will_look_down(const cf_flow_deck_t *deck);

// Finds the surface below: position [m, world], rotation matrix body to world (row-major).
void cf_flow_deck_look_down(cf_flow_deck_t *deck, const float position[3], const float rotation[9],
                            const cf_surroundings_t *surroundings);

// Advances by 1 ms: height of the body origin above the surface below [m], rotation matrix body to
// world (row-major), world velocity [m/s], body rates [rad/s]. Returns which registers it wrote,
// CF_FLOW_DECK_RANGE | CF_FLOW_DECK_FLOW; a drop-out is no reading at all. The range is
// CF_RANGE_NOTHING at 5 m and more or tilted beyond 84 deg; motion is CF_FLOW_NO_MOTION tilted so.
int cf_flow_deck_step(cf_flow_deck_t *deck, float height, const float rotation[9],
                      const float velocity_world[3], const float rates_body[3],
                      cf_flow_reading_t *reading);

#endif  // CF_VEHICLE_POSITIONING_FLOW_DECK_H
