/* The air moves: steady wind, turbulence, and a gust on command (docs/reference/vehicle.md#7).
 *
 * Turbulence is that of a room (each axis a first-order process) or Dryden's model for low
 * altitude. Each drone has its own; the steady wind is the same everywhere. It is felt through drag
 * and the moment of forward flight only. */
#ifndef CF_VEHICLE_WIND_H
#define CF_VEHICLE_WIND_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"
#include "vehicle/random.h"

typedef enum {
  CF_TURBULENCE_NONE   = 0,
  CF_TURBULENCE_INDOOR = 1,
  CF_TURBULENCE_DRYDEN = 2,
} cf_turbulence_t;

typedef struct {
  float           velocity[3];  // [m/s], world, steady
  cf_turbulence_t turbulence;
  float           indoor_deviation;  // [m/s] >= 0, per axis
  float           indoor_time;       // [s] > 0
  float           dryden_speed;      // [m/s] >= 0, wind at 6 m; 0 takes the steady wind
} cf_wind_config_t;

typedef struct {
  float            velocity[3];  // [m/s], world, all together, of the last update
  cf_wind_config_t config;
  bool             is_changing;  // turbulence or a gust: updates have something to do

  // turbulence
  float       filters[3][2];  // [m/s], states of the forming filters: along, across, up
  cf_random_t random;

  // gust: peak * (1 - cos(2 pi age / duration)) / 2
  float gust_peak[3];   // [m/s], world
  float gust_duration;  // [s], 0: none
  float gust_age;       // [s]
} cf_wind_t;

// Fills the wind. Returns CF_ERR_VALUE when a number of the config is outside its range.
cf_status_t cf_wind_init(cf_wind_t *wind, const cf_wind_config_t *config, cf_random_t random);

// Lets a gust begin now, in place of one that still blows: it rises to `peak` [m/s, world], each
// component within +-50, and is over after `duration` [s], more than 0 and at most 3600. Returns
// CF_ERR_VALUE for other numbers.
cf_status_t cf_wind_gust(cf_wind_t *wind, const float peak[3], float duration);

// Advances by some time [s], at a height [m] above the surface and a velocity [m/s, world].
void cf_wind_update(cf_wind_t *wind, float elapsed, float height, const float velocity[3]);

#endif  // CF_VEHICLE_WIND_H
