/* The force of one drone's wash on another one below it (docs/reference/vehicle.md#9).
 *
 *   F_z = -peak * strength * exp(-((dz - height) / depth)^2) * exp(-(r / w)^2 / 2),
 *   w = width - narrowing * dz
 *
 * for a drone dz above at the horizontal distance r; forces of several add up. This is a fit of a
 * network that was learned from flights of Crazyflies. It is the whole of the effect: the wash does
 * not count as wind as well. */
#ifndef CF_VEHICLE_DOWNWASH_H
#define CF_VEHICLE_DOWNWASH_H

#include <stdbool.h>

#include "status.h"

#define CF_DOWNWASH_REACH_DOWN 1.5f  // [m], of the fit
// [m]; beyond it less than 0.2 % is left, because widths end at 0.07 m
#define CF_DOWNWASH_REACH_ASIDE 0.25f

typedef struct {
  bool  is_enabled;
  float peak;       // [N] >= 0, below a drone of 34 g in hover
  float height;     // [m] >= 0, of the other one at the peak
  float depth;      // [m] > 0
  float width;      // [m] > 0
  float narrowing;  // [m/m] >= 0
} cf_downwash_config_t;

// Returns CF_ERR_VALUE when a number of the config is outside its range.
cf_status_t cf_downwash_check(const cf_downwash_config_t *config);

// Pure: how hard a drone of this mass [kg] blows while its rotors push with this thrust [N]; 1 for
// 34 g in hover.
float cf_downwash_strength(float mass, float thrust);

// Pure: the force [N] >= 0, downward, of a drone of this strength at this offset [m] from the one
// that feels it.
float cf_downwash_force(const cf_downwash_config_t *config, const float offset[3], float strength);

#endif  // CF_VEHICLE_DOWNWASH_H
