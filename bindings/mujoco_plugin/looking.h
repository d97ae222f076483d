/* What the ranging decks of drones see: scenery, bodies that move, and other drones. Internal to
 * the plugin.
 *
 * Nothing of it is state: it is made from positions in every step, and only when a drone asks.
 * Bodies that move are seen where MuJoCo's kinematics had them, at the start of the step. */
#ifndef CF_MUJOCO_PLUGIN_LOOKING_H
#define CF_MUJOCO_PLUGIN_LOOKING_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "mujoco_plugin/mujoco_api.h"
#include "mujoco_plugin/peer_grid.h"
#include "surroundings.h"

struct swarm_s;

// The surroundings of one drone; `motion.surroundings` points here.
typedef struct {
  cf_surroundings_t base;
  struct swarm_s   *swarm;
  int               self;  // index of the drone
} cf_view_t;

// The geoms of a drone that others see: those that collide.
typedef struct {
  int    first;   // geom of the body; meshes and SDFs among them are not seen
  int    count;   // geoms in a row
  double radius;  // [m], about the origin of the body
} cf_hull_t;

typedef struct {
  bool is_needed;  // a drone has a ranging deck, and there is more to see than a flat floor

  cf_view_t *views;   // [drones]
  cf_hull_t *hulls;   // [drones]
  double     widest;  // [m], largest radius of them

  int      mover_count;
  int32_t *movers;  // geoms of bodies that move and are no drones
  int32_t *hooks;   // weld by which a drone carries each, or -1
  mjData  *posed;   // where they were at the start of the step: geom_xpos and geom_xmat, no more

  cf_peer_grid_t grid;
  atomic_int     grid_state;  // in this step: not sorted, being sorted, sorted
} cf_looking_t;

// Prepares the swarm for looking, and gives their surroundings to the drones that need them.
// Returns false when there is no memory. cf_looking_free may follow in any case.
bool cf_looking_new(struct swarm_s *swarm, const mjModel *model);
void cf_looking_free(struct swarm_s *swarm);

// Starts a step, after the motions of all drones have been sampled. Nothing else may run meanwhile.
void cf_looking_begin(struct swarm_s *swarm, const mjData *data);

// Distance [m] for the drone `self`, or for no drone (-1); see surroundings.h. Several threads may
// call this at once.
float cf_looking_distance(struct swarm_s *swarm, int self, const float point[3],
                          const float direction[3], float cone, float reach);

#endif  // CF_MUJOCO_PLUGIN_LOOKING_H
