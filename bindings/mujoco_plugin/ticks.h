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

// Finishes the ticks, and turns overlapping on or off. While it is on no other thread may access
// the data.
void cf_ticks_overlap(swarm_t *swarm, bool is_overlapping);

// ---- parts of it, for windows.h

void cf_ticks_finish(swarm_t *swarm);

// A time that is a whole number of steps but for rounding is made one exactly: MuJoCo adds up its
// time step by step, which drifts by 0.1 ms in a day.
double cf_ticks_straight(const mjModel *model, double time);

// Ticks in the step that ends at a time [s], and whether drones look around after it.
int  cf_ticks_in_step(const mjModel *model, double time);
bool cf_ticks_look_is_due(const mjModel *model, double time);

// Decides what drones look at in the tick at a time [s], in which nothing touches anything; then
// whether one of them looks at others, and the look, after all motions have been sampled.
void cf_ticks_begin(swarm_t *swarm, const mjModel *model, mjData *data, double time);
bool cf_ticks_see_others(const swarm_t *swarm);
void cf_ticks_look(swarm_t *swarm, mjData *data);

// One tick of a few drones that have been sampled. Only the first after a look tells them what was
// seen; `rest` is where the drones end that this thread ticks next.
void cf_ticks_flock(const swarm_t *swarm, int begin, int end, bool is_first, int rest);

#endif  // CF_MUJOCO_PLUGIN_TICKS_H
