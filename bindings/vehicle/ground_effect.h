/* More thrust near a surface: one factor per rotor (docs/reference/vehicle.md#8).
 *
 *   T / T_free = 1 / (1 - (R / 4z)^2 - R^2 z / (d^2 + 4 z^2)^1.5
 *                       - (R^2 / 2) z / (2 d^2 + 4 z^2)^1.5 - 2 R^2 K_b z / (b^2 + 4 z^2)^1.5)
 *
 * with the height z of the rotor above the surface straight below, the distance d of adjacent
 * rotors and the diagonal b; at most `cap`. Above 1 m, and tilted by more than 60 degrees, there is
 * none. */
#ifndef CF_VEHICLE_GROUND_EFFECT_H
#define CF_VEHICLE_GROUND_EFFECT_H

#include <stdbool.h>

#include "status.h"
#include "vehicle/rotors.h"

typedef struct {
  bool  is_enabled;
  float body;           // >= 0, K_b
  float cap;            // >= 1, largest factor
  float lowest_height;  // [m] > 0, rotors count as at least this high
} cf_ground_effect_config_t;

typedef struct {
  cf_ground_effect_config_t config;

  // derived
  float radius2;    // [m^2], R^2
  float distance2;  // [m^2], d^2
  float diagonal2;  // [m^2], b^2

  // output of the last update
  float gain[CF_ROTOR_COUNT];  // >= 1, on the thrust
} cf_ground_effect_t;

// Fills the ground effect of a frame with these rotors. Returns CF_ERR_VALUE when a number of the
// config is outside its range.
cf_status_t cf_ground_effect_init(cf_ground_effect_t              *effect,
                                  const cf_ground_effect_config_t *config,
                                  const cf_rotors_config_t        *rotors);

// Takes the height [m] of the body origin above the surface and the attitude (body to world,
// row-major); the rotors are those of init.
void cf_ground_effect_update(cf_ground_effect_t *effect, const cf_rotors_config_t *rotors,
                             float height, const float rotation[9]);

#endif  // CF_VEHICLE_GROUND_EFFECT_H
