/* The ticks of a whole swarm, shared among threads. Internal to the plugin.
 *
 * MuJoCo calls advance at the end of a step and compute in the middle of the next one, after
 * kinematics and collisions. What the ticks produce is needed in compute only, so that within
 * World.step they may run beside the first half of the next step ("overlapping"). The bits are the
 * same. */
#ifndef CF_MUJOCO_PLUGIN_TICKS_H
#define CF_MUJOCO_PLUGIN_TICKS_H

#include "mujoco_plugin/swarm.h"

// Starts the ticks that are due after a step. They are finished on return unless the swarm is
// overlapping.
void cf_ticks_advance(const mjModel *model, mjData *data, swarm_t *swarm);

// Reads the poses of all drones as they are, for a look between two steps.
void cf_ticks_sample(swarm_t *swarm, const mjModel *model, mjData *data);

// Finishes the ticks, then adds the forces of all drones to qfrc_passive.
void cf_ticks_compute(const mjModel *model, mjData *data, swarm_t *swarm);

// Finishes the ticks, and turns overlapping on or off. While it is on nobody else may touch the
// data.
void cf_ticks_overlap(swarm_t *swarm, bool is_overlapping);

#endif  // CF_MUJOCO_PLUGIN_TICKS_H
