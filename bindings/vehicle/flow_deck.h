/* The flow deck: a VL53L1x looking down at 40 Hz and a PMW3901 counting pixels at 100 Hz.
 *
 * The floor is flat at z = 0. Range: along body -z, whole millimeters. Flow: whole counts, the
 * inverse of the filter's model (estimators dossier sections 5.7, 13.1 and 13.2). */
#ifndef CF_VEHICLE_FLOW_DECK_H
#define CF_VEHICLE_FLOW_DECK_H

#include <stdint.h>

#include "api/stabilizer_types.h"
#include "status.h"
#include "vehicle/random.h"

#define CF_FLOW_DECK_RANGE 1  // a range was measured at this tick
#define CF_FLOW_DECK_FLOW 2   // flow was measured at this tick

typedef struct {
  float range_noise_scale;  // [0, 100], on the standard deviation sigma(d); 0 = ideal
  float flow_noise;         // [counts] >= 0, standard deviation
  float flow_std;           // [counts] > 0, what the filter is told
} cf_flow_deck_config_t;

typedef struct {
  cf_flow_deck_config_t config;

  uint32_t    range_countdown;  // [ticks] to the next reading
  uint32_t    flow_countdown;   // [ticks]
  uint32_t    flow_age;         // [ticks] since the last reading that was no outlier
  cf_random_t random;
} cf_flow_deck_t;

// Fills the deck; the first readings come after one period. Returns CF_ERR_VALUE when a number of
// the config is outside its range.
cf_status_t cf_flow_deck_init(cf_flow_deck_t *deck, const cf_flow_deck_config_t *config,
                              cf_random_t random);

// Advances by 1 ms: height of the body origin above the floor [m], rotation matrix body to world
// (row-major), world velocity [m/s], body rates [rad/s], tick [ms] for the time stamps. Returns
// which measurements it wrote, CF_FLOW_DECK_RANGE | CF_FLOW_DECK_FLOW. There is no range at 5 m and
// more or tilted beyond 84 deg; no flow below 0.08 m, tilted so, or from 100 counts on.
int cf_flow_deck_step(cf_flow_deck_t *deck, uint32_t tick, float height, const float rotation[9],
                      const float velocity_world[3], const float rates_body[3],
                      tofMeasurement_t *range, flowMeasurement_t *flow);

// Pure: standard deviation [m] of a range [m], as the deck driver tells the filter.
float cf_range_std(float distance);

#endif  // CF_VEHICLE_FLOW_DECK_H
