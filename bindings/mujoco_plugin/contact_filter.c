#include "mujoco_plugin/contact_filter.h"

#include "mujoco_plugin/scenery.h"
#include "mujoco_plugin/sleep.h"
#include "mujoco_plugin/swarm.h"

// What stood where ours stands: like that place itself there is one for the process.
static mjfConFilt previous;

static bool has_no_common_bit(const mjModel *model, int a, int b) {
  return (model->geom_contype[a] & model->geom_conaffinity[b]) == 0 &&
         (model->geom_contype[b] & model->geom_conaffinity[a]) == 0;
}

static bool moves(const drone_t *drone, const mjModel *model, mjData *data, int body) {
  return drone != NULL ? !cf_sleep_holds(drone, data) : !cf_scenery_is_static(model, body);
}

// MuJoCo's own question about the bits is not asked where there is a filter. Asked for every pair
// that may touch, which is at least one per drone and step, so nothing in here may search: that
// would grow with the square of the swarm.
static int leaves_out(const mjModel *model, mjData *data, int geom1, int geom2) {
  if (previous != NULL ? previous(model, data, geom1, geom2)
                       : has_no_common_bit(model, geom1, geom2)) {
    return 1;
  }
  const int      bodies[2] = {model->geom_bodyid[geom1], model->geom_bodyid[geom2]};
  const drone_t *drones[2];
  for (int i = 0; i < 2; i++) {
    drones[i] = cf_swarm_drone_of_body(model, data, bodies[i]);
  }
  if (drones[0] != NULL && drones[1] != NULL && drones[0] != drones[1] &&
      (drones[0]->is_isolated || drones[1]->is_isolated)) {
    return 1;
  }
  return (drones[0] != NULL || drones[1] != NULL) && !moves(drones[0], model, data, bodies[0]) &&
         !moves(drones[1], model, data, bodies[1]);
}

void cf_contact_filter_install(const cf_mujoco_api_t *mj) {
  // read once: a filter that another thread has just put there must not become its own predecessor
  const mjfConFilt present = *mj->contact_filter;
  if (present != leaves_out) {
    previous            = present;
    *mj->contact_filter = leaves_out;
  }
}
