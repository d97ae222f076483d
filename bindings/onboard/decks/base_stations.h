/* What the onboard software knows of the base stations: geometry and calibration, flat.
 *
 * A sweep waits in the queue of the estimator with ids alone; `cf_lighthouse_resolve` makes the
 * pointers that the filter wants just before it is fused, so that no state ever holds one. */
#ifndef CF_ONBOARD_DECKS_BASE_STATIONS_H
#define CF_ONBOARD_DECKS_BASE_STATIONS_H

#include <stdbool.h>

#include "api/lighthouse_types.h"
#include "api/measurement.h"
#include "deck_facts.h"

typedef struct {
  vec3d                   origin;        // [m], world
  mat3d                   rotation;      // base station to world
  lighthouseCalibration_t calibration;   // valid when its flag says so
  bool                    has_geometry;  // origin and rotation are valid
} cf_station_data_t;

typedef struct {
  cf_station_data_t list[CF_LIGHTHOUSE_STATIONS];
} cf_base_stations_t;

// A sweep with its pointers, some of them into itself: for the caller's stack, not to be copied.
typedef struct {
  measurement_t measurement;
  mat3d         rotation_inverse;  // world to base station
} cf_resolved_sweep_t;

// Returns `measurement`, or for a sweep angle the same with its pointers filled, in `resolved`. The
// result lives as long as all three arguments. A sweep of an unknown station or sensor keeps null
// pointers.
const measurement_t *cf_lighthouse_resolve(cf_resolved_sweep_t      *resolved,
                                           const measurement_t      *measurement,
                                           const cf_base_stations_t *stations);

// Pure: turns both sweep angles [rad] of a sensor into a direction in the world, of any length.
void cf_lighthouse_ray(const cf_station_data_t *station, const float angles[CF_LIGHTHOUSE_SWEEPS],
                       float direction[3]);

#endif  // CF_ONBOARD_DECKS_BASE_STATIONS_H
