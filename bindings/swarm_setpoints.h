/* Setpoints of the commands that layers give a swarm: thrust and body rates, thrust and angles, or
 * velocities. Units are those of the layers (N, rad, right-handed), see common/messages.py. */
#ifndef CF_SWARM_SETPOINTS_H
#define CF_SWARM_SETPOINTS_H

#include <stdint.h>

#include "api/stabilizer_types.h"

typedef enum {
  CF_TWIST_FPQR,  // thrust [N] in linear z, body rates [rad/s] in angular
  CF_TWIST_FRPY,  // thrust [N] in linear z, roll, pitch and yaw [rad] in angular
  CF_TWIST_VEL,   // velocity [m/s, world] in linear, yaw rate [rad/s] in angular z
} cf_twist_kind_t;

// Writes a setpoint for each of `count` drones. `linear` and `angular` are (count, 3);
// `max_thrusts` is the thrust at full command [N], (count). Returns `count`, or the first drone of
// which a number is not finite.
int cf_make_setpoints(cf_twist_kind_t kind, int count, const double *linear, const double *angular,
                      const double *max_thrusts, uint32_t timestamp, setpoint_t *setpoints);

#endif  // CF_SWARM_SETPOINTS_H
