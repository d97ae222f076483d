/* Drones that stand or lie still with their rotors stopped are held: they keep their pose to the
 * last bit and leave out their contacts with what does not move, the floor and each other. A
 * contact costs the physics more than a whole tick, and heaps of crashed drones would creep for
 * ever.
 *
 * A held drone is let go when something acts on it: rotors or wind, a body that moves, a drone that
 * flies, a blow, a hand that moves it or gives it a velocity. When it really leaves its place,
 * those around it are let go as well, so that nothing hangs in the air; most of them come to rest
 * where they are. All state is in cf_rest_t, so that a restored flight is the same to the last bit.
 * Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_REST_H
#define CF_MUJOCO_PLUGIN_REST_H

#include "mujoco_plugin/swarm.h"

// At the end of a step: puts a held drone back to its pose or lets it go, and holds one that has
// been still long enough. Touches this drone only, and asks swarm->touched (touch.h).
void cf_rest_step(const swarm_t *swarm, int i, const mjModel *model, mjData *data, double elapsed);

// Whether a drone disturbs those that it touches. Depends on the state only.
bool cf_rest_is_lively(const drone_t *drone, mjData *data);

// Whether a drone with stopped rotors is no longer where it was, so that those that leaned on it
// have to follow: it moves, or a hand has moved it in this time [s].
bool cf_rest_has_left(const drone_t *drone, mjData *data, double elapsed);

// Whether a drone is held at the pose and with the velocity that it has now. Depends on the state
// only, and does not read what ticks write.
bool cf_rest_holds(const drone_t *drone, mjData *data);

// The generalized force that carries a held drone and what lies on it.
void cf_rest_force(const drone_t *drone, const mjModel *model, mjData *data, double out[6]);

#endif  // CF_MUJOCO_PLUGIN_REST_H
