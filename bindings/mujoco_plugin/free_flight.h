/* The motion of drones that nothing touches, integrated by the plugin and not by MuJoCo.
 *
 * MuJoCo solves the contacts of all bodies together, so that the last bits of a drone in the air
 * depend on how many others there are and on what those run into. A drone without contacts needs no
 * solver: it is a rigid body under known forces. At the end of a step its state is written again,
 * from the state and the forces that the step began with. The method is MuJoCo's semi-implicit
 * Euler step, and differs from it by rounding. Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_FREE_FLIGHT_H
#define CF_MUJOCO_PLUGIN_FREE_FLIGHT_H

#include "mujoco_plugin/swarm.h"

// Finds the drones that are one rigid body each, to which nothing is tied: those that can fly
// freely. Others stay with MuJoCo, and so does everything under other integrators than Euler.
void cf_free_flight_new(swarm_t *swarm, const mjModel *model);

// At the end of a step, before anything else looks at its result: writes qpos, qvel, qacc,
// qacc_warmstart and qfrc_constraint of all drones that touched nothing. The step began with
// work[].coordinates.
void cf_free_flight_step(swarm_t *swarm, const mjModel *model, mjData *data);

// One step of one drone from `start`, pose (7) and twist (6), under a generalized force without
// gravity: writes the same of it.
void cf_free_flight_move(drone_t *drone, const mjModel *model, mjData *data, const double start[13],
                         const double force[6]);

#endif  // CF_MUJOCO_PLUGIN_FREE_FLIGHT_H
