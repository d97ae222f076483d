#include "mujoco_plugin/contact_filter.h"

#include "mujoco_plugin/rest.h"
#include "mujoco_plugin/swarm.h"
#include "mujoco_plugin/touch.h"

// What stood where ours stands: like that place itself there is one for the process.
static mjfConFilt previous;

static bool has_no_common_bit(const mjModel *model, int a, int b) {
  return (model->geom_contype[a] & model->geom_conaffinity[b]) == 0 &&
         (model->geom_contype[b] & model->geom_conaffinity[a]) == 0;
}

static bool moves(const swarm_t *swarm, const mjModel *model, mjData *data, int body) {
  const drone_t *drone = cf_touch_drone_at(swarm, body);
  return drone != NULL ? !cf_rest_holds(drone, data) : !cf_scenery_is_static(model, body);
}

// MuJoCo's own question about the bits is not asked where there is a filter.
static int leaves_out(const mjModel *model, mjData *data, int geom1, int geom2) {
  if (previous != NULL ? previous(model, data, geom1, geom2)
                       : has_no_common_bit(model, geom1, geom2)) {
    return 1;
  }
  const swarm_t *swarm = cf_swarm_of(model, data);
  return swarm != NULL && !moves(swarm, model, data, model->geom_bodyid[geom1]) &&
         !moves(swarm, model, data, model->geom_bodyid[geom2]);
}

void cf_contact_filter_install(const cf_mujoco_api_t *mj) {
  // read once: a filter that another thread has just put there must not become its own predecessor
  const mjfConFilt present = *mj->contact_filter;
  if (present != leaves_out) {
    previous            = present;
    *mj->contact_filter = leaves_out;
  }
}
