/* Drones at rest with their rotors stopped are put to sleep: they are held at their
 * pose to the last bit and leave out their contacts with what does not move, the floor and each
 * other. A contact costs the physics more than a whole tick, and heaps of crashed drones would
 * creep without end.
 *
 * A drone wakes when something acts on it: rotors or wind, a body that moves, a drone that flies, a
 * blow, a hand that moves it or gives it a velocity. When it really leaves its place, those around
 * it wake as well, so that nothing hangs in the air; most of them stop where they are. All state is
 * in cf_sleep_t, so that a restored flight is the same to the last bit. Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_SLEEP_H
#define CF_MUJOCO_PLUGIN_SLEEP_H

#include "mujoco_plugin/swarm.h"

// At the end of a step, at a time [s] and as long [s] after the last one: puts a held drone back to
// its pose or wakes it, and puts one to sleep that has been still long enough. Touches this drone
// only, and asks swarm->touched (touch.h).
void cf_sleep_step(const swarm_t *swarm, int i, const mjModel *model, mjData *data, double time,
                   double elapsed);

// Whether a drone is awake, and disturbs those that it touches. Depends on the state only.
bool cf_sleep_is_awake(const drone_t *drone, mjData *data);

// Whether a drone with stopped rotors is no longer where it was, so that those that leaned on it
// have to follow: it moves, or a hand has moved it in this time [s].
bool cf_sleep_has_left(const drone_t *drone, mjData *data, double elapsed);

// Whether a drone is held at the pose and with the velocity that it has now. Depends on the state
// only, and does not read what ticks write.
bool cf_sleep_holds(const drone_t *drone, mjData *data);

// The generalized force that carries a held drone and what lies on it.
void cf_sleep_force(const drone_t *drone, const mjModel *model, mjData *data, double out[6]);

#endif  // CF_MUJOCO_PLUGIN_SLEEP_H
