/* How much room each drone has until something may touch it. Internal to the plugin.
 *
 * Gaps that were measured once last for many windows: what counts is how far drones have moved
 * since then. Nothing of it is state. */
#ifndef CF_MUJOCO_PLUGIN_ROOMS_H
#define CF_MUJOCO_PLUGIN_ROOMS_H

#include "mujoco_plugin/peer_grid.h"
#include "mujoco_plugin/swarm.h"

#define CF_ROOMS_REACH 0.4  // [m], more than any drone that may have a room

typedef struct {
  double place[3];     // where the gap was measured [m]
  double gap;          // half of the way to the nearest other drone [m]
  double most_thrust;  // [N]
  bool   is_held;
} cf_room_t;

typedef struct {
  cf_peer_grid_t grid;
  cf_room_t     *of;  // [drones]
} cf_rooms_t;

// Returns false when there is no memory; cf_rooms_free may follow in any case.
bool cf_rooms_new(cf_rooms_t *rooms, const swarm_t *swarm);
void cf_rooms_free(cf_rooms_t *rooms);

// Whether nothing can touch anything for so many ticks over an empty floor at z = 0, as long as no
// held drone wakes.
bool cf_rooms_suffice(cf_rooms_t *rooms, const swarm_t *swarm, const mjModel *model, mjData *data,
                      int ticks);

#endif  // CF_MUJOCO_PLUGIN_ROOMS_H
