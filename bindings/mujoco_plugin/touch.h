/* Whom a drone touches, as far as resting goes. Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_TOUCH_H
#define CF_MUJOCO_PLUGIN_TOUCH_H

#include "mujoco_plugin/swarm.h"

// From the harmless to what wakes; the strongest counts.
enum {
  CF_TOUCH_NONE  = 0,  // nothing, or what never moves: the floor
  CF_TOUCH_DRONE = 1,  // another drone whose rotors do not push
  CF_TOUCH_HELD  = 2,  // a drone around it was just held, and pushes it no more
  CF_TOUCH_LEFT  = 3,  // a drone that may have carried it has left its place
  CF_TOUCH_MOVER = 4,  // a body that moves, a drone that flies
};

// Nothing touches anything.
void cf_touch_forget(swarm_t *swarm);

// Fills swarm->touched from the contacts of the steps that just ended, a time [s] together. One
// thread for all drones.
void cf_touch_look(const mjModel *model, mjData *data, swarm_t *swarm, double elapsed);

// The drone that a body belongs to, or NULL.
const drone_t *cf_touch_drone_at(const swarm_t *swarm, int body);

#endif  // CF_MUJOCO_PLUGIN_TOUCH_H
