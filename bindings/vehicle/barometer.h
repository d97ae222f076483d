/* The BMP388: pressure of the air at 50 Hz, with noise and drift
 * (docs/reference/estimators.md#12.1, docs/reference/vehicle.md#10).
 *
 * The pressure is that of the standard atmosphere which the onboard software takes for granted, so
 * that an ideal sensor gives back the height, in steps of 5 mm. Near the floor the wash of the
 * propellers shifts it, by a share of the vibration's (speed / speed in hover)^2 that falls off
 * with the height; by how much, and with which sign, is not the same for two drones. Wind is left
 * out. */
#ifndef CF_VEHICLE_BAROMETER_H
#define CF_VEHICLE_BAROMETER_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"
#include "vehicle/random.h"

#define CF_BAROMETER_TICKS 20  // from one sample to the next

typedef struct {
  float altitude;     // [-500, 9000] m, of the world's z = 0 above sea level
  float noise;        // [m] >= 0, standard deviation of a sample
  float drift;        // [m] >= 0, standard deviation of an error that wanders within minutes
  float wash_low;     // [m], the shift on the floor with the rotors at the speed of hover is drawn
  float wash_high;    // [m], at init from wash_low to wash_high; both at least -10 and at most 10
  float wash_height;  // [m] > 0, over which the shift falls to 1/e
  float noise_scale;  // [0, 100], on noise, drift and shift; 0 = ideal
} cf_barometer_config_t;

typedef struct {
  cf_barometer_config_t config;

  float       wash;       // [m], the shift of this drone
  float       wander;     // [m], the drift as it is now; 0 at the start
  uint32_t    countdown;  // [ticks] to the next sample
  cf_random_t random;
} cf_barometer_t;

// Fills the sensor; the first sample comes after one period. Returns CF_ERR_VALUE when a number of
// the config is outside its range.
cf_status_t cf_barometer_init(cf_barometer_t *barometer, const cf_barometer_config_t *config,
                              cf_random_t random);

// Advances by 1 ms at a height [m] in the world, below 20 km, over a surface at a height [m] as
// well, with the vibration of the rotors (1 in hover). Returns whether it wrote a sample: pressure
// [Pa] and temperature [deg C].
bool cf_barometer_step(cf_barometer_t *barometer, float height, float surface, float vibration,
                       float *pressure, float *temperature);

// Pure: the pressure [Pa] at a height above sea level [m].
float cf_pressure_at(float asl);

#endif  // CF_VEHICLE_BAROMETER_H
