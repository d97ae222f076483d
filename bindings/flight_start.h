/* Flights that begin in the air: a drone becomes a copy of one that flies, somewhere else and with
 * other dice. For learners, which start a flight a thousand times a second.
 *
 * The copy knows where it is: the Kalman filter, its estimate and the filters of the sensors are
 * those of a drone that has always moved so, with the covariance of the pattern. Loops of the PID
 * controller begin again. Poses of the motion capture that were under way are lost, which is one
 * frame; other positioning systems go on from the new place. */
#ifndef CF_FLIGHT_START_H
#define CF_FLIGHT_START_H

#include <stdint.h>

#include "crazyflie.h"

// How a flight begins.
typedef struct {
  double   position[3];   // [m], world
  double   quat_wxyz[4];  // body to world, of norm 1
  double   velocity[3];   // [m/s], world
  double   rates[3];      // [rad/s], body
  uint64_t seed;          // of all noise from now on; turn-on errors are those of the pattern
  uint64_t id;            // equal seeds and different ids give independent noise
} cf_flight_start_t;

// Makes `cf` a copy of `pattern` that begins so. Both have the built-in provider; the body in the
// simulation is moved by the caller. Returns CF_ERR_VALUE and changes nothing for numbers that are
// not finite or a quaternion whose norm is off by 1 %, CF_ERR_STATE for another provider.
cf_status_t cf_start_flight(cf_t *cf, const cf_t *pattern, const cf_flight_start_t *start);

// Flights of one task side by side, as their owner keeps them; arrays have a row for each flight.
typedef struct {
  cf_t *const  *drones;
  cf_t *const  *patterns;
  const double *starts;      // `ahead` rows for each flight, of `start_size` numbers: a
                             // cf_flight_start_t, the number of its pattern, and its plan
  int           start_size;  // [numbers]
  int           plan_size;   // [numbers]
  int           ahead;       // episodes whose starts are known
  int           action_size;
  int64_t      *episodes;  // the next one of each
  int64_t      *steps;     // flown of the present one
  double       *plans;
  float        *actions;  // the latest of each
  float        *previous_actions;
  double       *qpos;         // of the bodies, poses of 7 numbers
  double       *qvel;         // twists of 6 numbers
  int           qpos_stride;  // [numbers] from one to the next
  int           qvel_stride;
} cf_flights_t;

// Begins the next episode of some flights: drone and body are moved, steps and actions are zero,
// and the episode is counted. Returns how many have begun: all, or those before the first refusal,
// of which `status` tells the reason.
int cf_start_flights(const cf_flights_t *flights, const int32_t *numbers, int count,
                     cf_status_t *status);

#endif  // CF_FLIGHT_START_H
