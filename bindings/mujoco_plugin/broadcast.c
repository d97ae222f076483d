#include "mujoco_plugin/broadcast.h"

#include <math.h>

#include "mujoco_plugin/motion.h"

#define IDS 255  // 1 to 255; 0 is an empty entry

_Static_assert(PEER_LOCALIZATION_MAX_NEIGHBORS <= CF_PEER_GRID_MAX, "a table is filled at once");

bool cf_broadcast_is_due(double before, double now) {
  return floor(now / CF_BROADCAST_PERIOD) > floor(before / CF_BROADCAST_PERIOD);
}

bool cf_broadcast_has_listeners(const swarm_t *swarm) {
  for (int i = 0; i < swarm->count; i++) {
    if (!swarm->drones[i].is_isolated && cf_state_of(&swarm->drones[i], swarm->data)->wants_peers) {
      return true;
    }
  }
  return false;
}

void cf_broadcast_look(swarm_t *swarm) {
  cf_peer_grid_clear(&swarm->peers);
  for (int i = 0; i < swarm->count; i++) {
    const cf_t *cf = cf_state_of(&swarm->drones[i], swarm->data);
    if (!swarm->drones[i].is_isolated && !cf_vehicle_is_out_of_sight(&cf->vehicle)) {
      cf_peer_grid_add(&swarm->peers, i, swarm->work[i].motion.position);
    }
  }
  cf_peer_grid_sort(&swarm->peers);
}

// Ids repeat in swarms of more than 255. This is harmless: each neighbor gets an entry of its own.
static uint8_t id_of(int index) {
  return (uint8_t)(index % IDS + 1);
}

void cf_broadcast_tell(const swarm_t *swarm, int i) {
  cf_t *cf = cf_state_of(&swarm->drones[i], swarm->data);
  if (!cf->wants_peers || swarm->drones[i].is_isolated) {
    return;
  }
  cf_seen_drone_t nearest[PEER_LOCALIZATION_MAX_NEIGHBORS];
  cf_peer_t       peers[PEER_LOCALIZATION_MAX_NEIGHBORS];
  const int count = cf_peer_grid_nearest(&swarm->peers, swarm->work[i].motion.position, i, nearest,
                                         PEER_LOCALIZATION_MAX_NEIGHBORS);
  for (int k = 0; k < count; k++) {
    const float *position = nearest[k].position;
    peers[k]              = (cf_peer_t){
        .id  = id_of(nearest[k].index),
        .pos = {.x = position[0], .y = position[1], .z = position[2]},
    };
  }
  cf_tell_peers(cf, peers, count);
}
