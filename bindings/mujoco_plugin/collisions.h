/* Contacts of drones that begin, as MuJoCo detected them, reported once. Internal to the plugin.
 *
 * What a drone touches already is stored in the drone (contacts.h), so that a restored flight
 * reports the same. Reported contacts are queued here until the caller takes them. */
#ifndef CF_MUJOCO_PLUGIN_COLLISIONS_H
#define CF_MUJOCO_PLUGIN_COLLISIONS_H

#include "mujoco_plugin/collision.h"
#include "mujoco_plugin/mujoco_api.h"

struct swarm_s;

#define CF_MOST_COLLISIONS 512

typedef struct {
  int            count;
  uint32_t       lost;  // begun while there was no room
  cf_collision_t list[CF_MOST_COLLISIONS];
} cf_collisions_t;

// Looks at the contacts of the step that just ended, before the ticks that follow it.
void cf_collisions_look(struct swarm_s *swarm, const mjModel *model, mjData *data);

#endif  // CF_MUJOCO_PLUGIN_COLLISIONS_H
