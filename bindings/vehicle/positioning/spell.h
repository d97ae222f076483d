/* Spells of a positioning system: times in which something is wrong, such as a drone out of sight.
 *
 * A spell begins by chance, `rate` times per second on average, and lasts between one frame and
 * twice its mean time, uniformly. Spells of one kind do not overlap. */
#ifndef CF_VEHICLE_POSITIONING_SPELL_H
#define CF_VEHICLE_POSITIONING_SPELL_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"
#include "vehicle/random.h"

typedef struct {
  float rate;  // [1/s], [0, 100], how often one begins; 0 = never
  float time;  // [s], [0, 100], how long it lasts on average
} cf_spell_config_t;

// Returns CF_ERR_VALUE when a number is outside its range.
cf_status_t cf_spell_check(const cf_spell_config_t *config);

// Advances by one frame of a system with `frames` frames per second. `left` counts the frames that
// the spell still lasts; 0 = all is well. Draws no number of `random` while the rate is 0. Returns
// true at the first frame of a spell.
bool cf_spell_step(const cf_spell_config_t *config, uint32_t frames, uint32_t *left,
                   cf_random_t *random);

#endif  // CF_VEHICLE_POSITIONING_SPELL_H
