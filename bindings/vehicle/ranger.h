/* VL53L1x: the chip that measures distances on the flow deck, the z-ranger and the multi-ranger.
 *
 * Whole millimeters along one axis of the body, from its origin (docs/reference/estimators.md#13.1,
 * docs/reference/vehicle.md#10). Its field of view is 27 degrees: walls and floors are measured
 * along the axis, as their strongest echo is; a drone, which is small, is seen anywhere in that
 * cone by the sideways chips. The chip that looks down has the filter's model of a flat floor to
 * agree with and sees what is on its axis only. */
#ifndef CF_VEHICLE_RANGER_H
#define CF_VEHICLE_RANGER_H

#include <stdbool.h>
#include <stdint.h>

#include "deck_facts.h"
#include "surroundings.h"
#include "vehicle/positioning/mishap.h"
#include "vehicle/random.h"

#define CF_MULTIRANGER_TICKS 100  // between two readings: 10 Hz
#define CF_ZRANGER_TICKS 25       // 40 Hz

// The decks that carry such chips and nothing else.
typedef struct {
  bool has_multiranger;  // front, back, up, left, right
  bool has_zranger;      // down
} cf_rangers_config_t;

typedef struct {
  cf_rangers_config_t fitted;
  float               noise_scale;  // [0, 100], on the standard deviation sigma(d); 0 = ideal
  cf_mishap_config_t  mishap;       // of one range; size in m

  uint32_t    multiranger_countdown;  // [ticks] to the next reading
  uint32_t    zranger_countdown;      // [ticks]
  cf_random_t random;                 // noise
  cf_random_t mishap_random;          // drop-outs and outliers
} cf_rangers_t;

// Fills the decks; the first readings come after one period. Noise and mishaps have been checked.
void cf_rangers_init(cf_rangers_t *rangers, const cf_rangers_config_t *config, float noise_scale,
                     const cf_mishap_config_t *mishap, uint64_t seed, uint64_t id);

// Advances by 1 ms at a position [m, world] and attitude (body to world, row-major). Returns which
// directions were measured, bit 1 << CF_RANGE_FRONT and so on, and writes their readings [mm].
int cf_rangers_step(cf_rangers_t *rangers, const float position[3], const float rotation[9],
                    const cf_surroundings_t *surroundings, uint16_t readings[CF_RANGE_COUNT]);

// Pure: the reading [mm] of a true distance [m] with a normal number and an error [m];
// CF_RANGE_NOTHING at 5 m and more.
uint16_t cf_ranger_reading(float distance, float noise_scale, float normal, float wrong);

// How far a chip has to look [m], so that rounding does not bring anything back into its range.
#define CF_RANGER_REACH 6.0f

// Pure: distance [m] to what is on the axis straight down.
float cf_ranger_look_down(const float position[3], const float rotation[9],
                          const cf_surroundings_t *surroundings);

#endif  // CF_VEHICLE_RANGER_H
