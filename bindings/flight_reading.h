/* What learners look at of many drones after each step, read in one call. */
#ifndef CF_FLIGHT_READING_H
#define CF_FLIGHT_READING_H

#include <stdint.h>

#include "crazyflie.h"

// Of one drone, as it believes: what its controller sees in the next tick.
typedef struct {
  float   position[3];        // [m], world
  float   velocity[3];        // [m/s], world
  float   rotation[9];        // body to world, row by row
  float   rates[3];           // [rad/s], body: the filtered gyroscope
  float   specific_force[3];  // [m/s^2], body: the filtered accelerometer, +9.81 along z at rest
  float   battery_voltage;    // [V]
  int32_t is_out;             // 1: the core or the supervisor has stopped it
  int32_t is_touching;        // 1: it touched something within the latest ticks that were asked for
} cf_flight_reading_t;

// Reads `count` drones; `ticks` [ms] is how long a contact counts.
void cf_read_flights(const cf_t *const *drones, int count, uint32_t ticks,
                     cf_flight_reading_t *readings);

// Rotation matrices, row by row, of `count` unit quaternions (w, x, y, z) that lie `stride` numbers
// apart.
void cf_rotations_of(const double *quats, int count, int stride, float *rotations);

#endif  // CF_FLIGHT_READING_H
