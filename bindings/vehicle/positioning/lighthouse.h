/* Lighthouse positioning: two base stations of the second generation sweep the room, four sensors
 * on the deck feel their light.
 *
 * Each rotor carries two light planes, tilted by -30 and +30 degrees and a third of a turn apart;
 * a plane that passes the deck gives one angle per sensor (docs/reference/estimators.md#5.11 and
 * #13.4, docs/reference/vehicle.md#10). The stations turn at slightly different speeds, as channels
 * do. A sensor is hit when it is in front of the station within 75 degrees to the sides and 55 up
 * and down, at most 7 m away, and when the light falls on the top of the deck at 5 degrees or
 * more. The drone itself casts no shadow. */
#ifndef CF_VEHICLE_POSITIONING_LIGHTHOUSE_H
#define CF_VEHICLE_POSITIONING_LIGHTHOUSE_H

#include <stdbool.h>
#include <stdint.h>

#include "api/lighthouse_types.h"
#include "deck_facts.h"
#include "status.h"
#include "vehicle/positioning/mishap.h"
#include "vehicle/random.h"

// A base station stands upright.
typedef struct {
  float position[3];  // [m], world; at most 1000 m from the origin
  float target[3];    // [m], what it looks at; at least 0.01 m away from it
} cf_station_pose_t;

typedef struct {
  cf_station_pose_t stations[CF_LIGHTHOUSE_STATIONS];  // as the geometry on the drone says

  uint32_t rate;               // [Hz], turns of a rotor, 0 (off) to 100
  float    noise;              // [rad] >= 0, standard deviation of an angle
  float    calibration_error;  // [rad] >= 0, standard deviation of each plane's unknown phase, tilt
  float    position_error;     // [m] >= 0, standard deviation per axis: stations are elsewhere
  float    attitude_error;     // [rad] >= 0, standard deviation per axis: and turned otherwise

  cf_mishap_config_t mishap;  // of one sensor and sweep; size in rad
} cf_lighthouse_config_t;

// A base station as it really is.
typedef struct {
  vec3d    position;                     // [m], world
  mat3d    rotation;                     // base station to world
  float    phase[CF_LIGHTHOUSE_SWEEPS];  // [rad], added to the angles
  float    tilt[CF_LIGHTHOUSE_SWEEPS];   // [rad], of the light planes
  uint32_t period_us;                    // [us], of a turn; 0 = stands still
  uint32_t turned_us;                    // [us], since the first plane passed
} cf_base_station_t;

typedef struct {
  cf_lighthouse_config_t config;
  bool                   is_lost;  // while true no sensor sees any light

  cf_base_station_t stations[CF_LIGHTHOUSE_STATIONS];
  cf_random_t       random;         // noise
  cf_random_t       mishap_random;  // drop-outs and outliers
} cf_lighthouse_t;

// Fills the system. `world` gives the errors of the stations: drones that share a room pass equal
// ones. Returns CF_ERR_VALUE when a number of the config is outside its range.
cf_status_t cf_lighthouse_init(cf_lighthouse_t *lighthouse, const cf_lighthouse_config_t *config,
                               cf_random_t random, cf_random_t mishap_random, cf_random_t world);

// Advances by 1 ms with the true position [m] and rotation (body to world, row-major). Writes the
// sweeps that hit a sensor at this tick and returns how many they are.
int cf_lighthouse_step(cf_lighthouse_t *lighthouse, const float position[3],
                       const float rotation[9], cf_sweep_t sweeps[CF_LIGHTHOUSE_STATIONS]);

// Pure: the angle [rad] at which a light plane tilted by `tilt` [rad] passes the point x, y, z [m]
// in the frame of the station. Not a number where it never does.
float cf_sweep_angle(float x, float y, float z, float tilt);

#endif  // CF_VEHICLE_POSITIONING_LIGHTHOUSE_H
