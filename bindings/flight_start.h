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

// The same for some drones of a swarm: patterns[chosen[k]] for drones[numbers[k]]. Returns how many
// have begun: all, or those before the first refusal, of which `status` tells the reason.
int cf_start_flights(cf_t *const *drones, const int32_t *numbers, int count, cf_t *const *patterns,
                     const int32_t *chosen, const cf_flight_start_t *starts, cf_status_t *status);

#endif  // CF_FLIGHT_START_H
