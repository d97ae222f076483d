#include "mujoco_plugin/swarm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_plugin/attributes.h"
#include "mujoco_plugin/downwash.h"
#include "mujoco_plugin/rotation.h"
#include "providers.h"

#define TICK 0.001  // [s]

// Which plugins of a model are ours: one number for the process, given at registration.
static int slot = -1;

void cf_swarm_set_slot(int registered) {
  slot = registered;
}

bool cf_swarm_has(const mjModel *model, int instance) {
  return model->plugin[instance] == slot;
}

static const char *body_name(const cf_mujoco_api_t *mj, const mjModel *model, int body) {
  const char *name = mj->id2name(model, mjOBJ_BODY, body);
  return name != NULL && name[0] != '\0' ? name : "(unnamed)";
}

static int find_body(const mjModel *model, int instance) {
  for (int body = 0; body < model->nbody; body++) {
    if (model->body_plugin[body] == instance) {
      return body;
    }
  }
  return -1;
}

static double length_of(const double vector[3]) {
  return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

// R diag(d) R^T for the frame that MuJoCo aligned with the principal axes.
static void rotated_diagonal(const double quat[4], const double diagonal[3], double out[9]) {
  double r[9];
  cf_rotation_of(quat, r);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      double sum = 0;
      for (int k = 0; k < 3; k++) {
        sum += r[3 * i + k] * diagonal[k] * r[3 * j + k];
      }
      out[3 * i + j] = sum;
    }
  }
}

void cf_drone_read_inertia(drone_t *drone, const mjModel *model) {
  const double *diagonal = model->body_inertia + 3 * drone->body;
  const double *frame    = model->body_iquat + 4 * drone->body;
  if (memcmp(drone->principal, diagonal, 3 * sizeof *diagonal) == 0 &&
      memcmp(drone->principal + 3, frame, 4 * sizeof *frame) == 0) {
    return;
  }
  memcpy(drone->principal, diagonal, 3 * sizeof *diagonal);
  memcpy(drone->principal + 3, frame, 4 * sizeof *frame);
  const double inverse[3] = {1 / diagonal[0], 1 / diagonal[1], 1 / diagonal[2]};
  rotated_diagonal(frame, diagonal, drone->inertia);
  rotated_diagonal(frame, inverse, drone->inverse_inertia);
}

static void read_weight(drone_t *drone, const mjModel *model) {
  const double mass = model->body_mass[drone->body];
  drone->can_sleep  = model->tree_dofnum[drone->tree] == 6 &&
                      model->body_subtreemass[drone->body] <= mass &&
                      model->body_gravcomp[drone->body] == 0;
  drone->weight     = mass * length_of(model->opt.gravity);
}

// The estimator starts where the model places the drone, as careful users set kalman.initial*
// (docs/reference/estimators.md#18).
static void read_start_pose(drone_t *drone, const mjModel *model) {
  const double *pose = model->qpos0 + drone->qpos_address;
  for (int i = 0; i < 3; i++) {
    drone->config->start_position[i] = (float)pose[i];
  }
  const double w = pose[3], x = pose[4], y = pose[5], z = pose[6];
  drone->config->start_yaw = (float)atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

static void read_attributes(const cf_mujoco_api_t *mj, drone_t *drone, const mjModel *model,
                            int index) {
  cf_config_default(drone->config, CF_PLATFORM_CF2);
  drone->config->id = (uint32_t)index;
  for (int i = 0; i < cf_attribute_count(); i++) {
    char        message[CF_ATTRIBUTE_MESSAGE_BYTES];
    const char *text = mj->get_config(model, drone->instance, cf_attribute_name(i));
    if (cf_attribute_set(drone->config, i, text, message) != CF_OK) {
      mj->error("crazyflie %s: %s", body_name(mj, model, drone->body), message);
    }
  }
}

// What the model says itself: the mass of the body, and the wind of <option>.
static void take_from_model(const cf_mujoco_api_t *mj, drone_t *drone, const mjModel *model) {
  cf_config_t stock;
  cf_config_default(&stock, drone->config->platform);
  cf_airframe_t *airframe = &drone->config->vehicle.airframe;
  if (airframe->mass != stock.vehicle.airframe.mass ||
      memcmp(airframe->inertia, stock.vehicle.airframe.inertia, sizeof airframe->inertia) != 0) {
    mj->error("crazyflie %s: vehicle sets mass or inertia, which belong to <inertial> of the body",
              body_name(mj, model, drone->body));
  }
  airframe->mass = (float)model->body_mass[drone->body];
  for (int i = 0; i < 3; i++) {
    airframe->wind.velocity[i] += (float)model->opt.wind[i];
  }
}

int cf_swarm_provider(const cf_mujoco_api_t *mj, const mjModel *model, int instance) {
  cf_config_t config;
  cf_config_default(&config, CF_PLATFORM_CF2);
  for (int i = 0; i < cf_attribute_count(); i++) {
    char        message[CF_ATTRIBUTE_MESSAGE_BYTES];
    const char *name = cf_attribute_name(i);
    if (strcmp(name, "platform") == 0 || strcmp(name, "provider") == 0) {
      cf_attribute_set(&config, i, mj->get_config(model, instance, name), message);
    }
  }
  return config.provider;
}

// The state of a drone has the size that the provider asked for when the model was compiled.
static void check_size(const cf_mujoco_api_t *mj, const drone_t *drone, const mjModel *model) {
  const int bytes = model->plugin_statenum[drone->instance] * (int)sizeof(mjtNum);
  if (bytes != cf_state_bytes(drone->config->provider)) {
    mj->error(
        "crazyflie %s: provider '%s' was built again and keeps more or less than before; compile "
        "the model again",
        body_name(mj, model, drone->body), cf_provider_name(drone->config->provider));
  }
}

static bool has_controller(const void *provider, int number) {
  return number == ControllerTypeAutoSelect ||
         ((const cf_provider_t *)provider)->controller_name(number) != NULL;
}

static bool has_estimator(const void *provider, int number) {
  return number == StateEstimatorTypeAutoSelect || cf_estimator_exists(provider, number);
}

static void refuse_unknown(const cf_mujoco_api_t *mj, const drone_t *drone, const mjModel *model) {
  const cf_provider_t *provider      = cf_provider(drone->config->provider);
  const bool           is_controller = !has_controller(provider, drone->config->controller);
  const char          *what          = is_controller ? "controller" : "estimator";
  char                 allowed[CF_ATTRIBUTE_MESSAGE_BYTES] = "";
  for (int i = 0; i < cf_attribute_count(); i++) {
    if (strcmp(cf_attribute_name(i), what) == 0) {
      cf_attribute_choices(i, is_controller ? has_controller : has_estimator, provider, allowed,
                           (int)sizeof allowed);
    }
  }
  mj->error("crazyflie %s: %s is '%s', but provider '%s' has none of that name, allowed: %s",
            body_name(mj, model, drone->body), what, mj->get_config(model, drone->instance, what),
            cf_provider_name(drone->config->provider), allowed);
}

// Numbers that are fine by themselves may not fit together.
static void check_config(const cf_mujoco_api_t *mj, const drone_t *drone, const mjModel *model) {
  cf_t *trial = malloc((size_t)cf_state_bytes(drone->config->provider));
  if (trial == NULL) {
    return;
  }
  const cf_status_t status = cf_init(trial, drone->config);
  char              failure[CF_FAILURE_BYTES];
  memcpy(failure, trial->onboard.failure, sizeof failure);
  free(trial);
  if (status == CF_ERR_UNKNOWN) {
    refuse_unknown(mj, drone, model);
  } else if (status != CF_OK && failure[0] != '\0') {
    mj->error("crazyflie %s: provider '%s' cannot boot: %s", body_name(mj, model, drone->body),
              cf_provider_name(drone->config->provider), failure);
  } else if (status == CF_ERR_CAPACITY) {
    mj->error(
        "crazyflie %s: mocap_latency_ms is %u at a mocap_rate of %u Hz, allowed: fewer than %d "
        "poses under way",
        body_name(mj, model, drone->body), (unsigned)drone->config->vehicle.mocap.latency_ms,
        (unsigned)drone->config->vehicle.mocap.rate, CF_MOCAP_CAPACITY);
  } else if (status != CF_OK) {
    // no attributes are known that lead here: each has its range
    mj->error("crazyflie %s: cannot be built: %s", body_name(mj, model, drone->body),
              cf_status_text(status));
  }
}

static void bind(const cf_mujoco_api_t *mj, drone_t *drone, const mjModel *model, int index) {
  drone->body = find_body(model, drone->instance);
  if (drone->body < 0) {
    mj->error("crazyflie: plugin instance %d is not used by any body", drone->instance);
  }
  const int joint = model->body_jntadr[drone->body];
  if (joint < 0 || model->jnt_type[joint] != mjJNT_FREE) {
    mj->error("crazyflie %s: the body has no free joint; add <freejoint/> to it",
              body_name(mj, model, drone->body));
  }

  drone->tree          = model->body_treeid[drone->body];
  drone->qpos_address  = model->jnt_qposadr[joint];
  drone->dof_address   = model->jnt_dofadr[joint];
  drone->state_address = model->plugin_stateadr[drone->instance];
  cf_drone_read_inertia(drone, model);
  read_weight(drone, model);
  read_attributes(mj, drone, model, index);
  drone->is_isolated = drone->config->is_isolated;
  take_from_model(mj, drone, model);
  read_start_pose(drone, model);
  check_size(mj, drone, model);
  check_config(mj, drone, model);
}

static void map_bodies(swarm_t *swarm, const mjModel *model) {
  for (int body = 0; body < model->nbody; body++) {
    swarm->drone_of_body[body] = -1;
  }
  for (int i = 0; i < swarm->count; i++) {
    swarm->drone_of_body[swarm->drones[i].body] = i;
  }
  for (int body = 1; body < model->nbody; body++) {
    swarm->drone_of_body[body] = swarm->drone_of_body[model->body_rootid[body]];
  }
}

// How far from the origin of its drone a body may be, in whatever way it is turned.
static double distance_from_root(const mjModel *model, int body) {
  double sum = 0;
  for (; body != model->body_rootid[body]; body = model->body_parentid[body]) {
    sum += length_of(model->body_pos + 3 * body);
  }
  return sum;
}

static void measure_reach(swarm_t *swarm, const mjModel *model) {
  for (int geom = 0; geom < model->ngeom; geom++) {
    const int body  = model->geom_bodyid[geom];
    const int index = swarm->drone_of_body[body];
    if (index >= 0 && (model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0)) {
      drone_t     *drone = &swarm->drones[index];
      const double reach = distance_from_root(model, body) + length_of(model->geom_pos + 3 * geom) +
                           model->geom_rbound[geom];
      drone->reach       = fmax(drone->reach, reach);
    }
  }
}

static void number_things(swarm_t *swarm, const mjModel *model) {
  int32_t next = 0;
  for (int geom = 0; geom < model->ngeom; geom++) {
    swarm->thing_of_geom[geom] = next;
    next += model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0;
  }
  swarm->thing_of_geom[model->ngeom] = next;
}

// What cf_swarm_free frees. Returns false when there is no memory.
static bool allocate(swarm_t *swarm, const cf_mujoco_api_t *mj, const mjModel *model) {
  const size_t most    = (size_t)model->nplugin;
  swarm->mj            = mj;
  swarm->drones        = calloc(most, sizeof *swarm->drones);
  swarm->configs       = calloc(most, sizeof *swarm->configs);
  swarm->work          = calloc(most, sizeof *swarm->work);
  swarm->touched       = calloc(most, sizeof *swarm->touched);
  swarm->in_contact    = calloc(most, sizeof *swarm->in_contact);
  swarm->drone_of_body = calloc((size_t)model->nbody, sizeof *swarm->drone_of_body);
  swarm->thing_of_geom = calloc((size_t)model->ngeom + 1, sizeof *swarm->thing_of_geom);
  swarm->collisions    = calloc(1, sizeof *swarm->collisions);
  swarm->scenery       = cf_scenery_new(mj, model);
  return swarm->drones != NULL && swarm->configs != NULL && swarm->work != NULL &&
         swarm->touched != NULL && swarm->in_contact != NULL && swarm->drone_of_body != NULL &&
         swarm->thing_of_geom != NULL && swarm->collisions != NULL && swarm->scenery != NULL &&
         cf_peer_grid_new(&swarm->peers, (int)model->nplugin);
}

static void bind_all(swarm_t *swarm, const cf_mujoco_api_t *mj, const mjModel *model) {
  for (int instance = 0; instance < model->nplugin; instance++) {
    if (cf_swarm_has(model, instance)) {
      drone_t *drone       = &swarm->drones[swarm->count];
      drone->swarm         = swarm;
      drone->config        = &swarm->configs[swarm->count];
      drone->instance      = instance;
      swarm->last_instance = instance;
      bind(mj, drone, model, swarm->count);
      swarm->count++;
    }
  }
}

// no test runs out of memory
static swarm_t *refuse(swarm_t *swarm, const cf_mujoco_api_t *mj) {
  if (swarm != NULL) {
    cf_swarm_free(swarm);
  }
  mj->error("crazyflie: out of memory");
  return NULL;
}

swarm_t *cf_swarm_new(const cf_mujoco_api_t *mj, const mjModel *model) {
  swarm_t *swarm = calloc(1, sizeof *swarm);
  if (swarm == NULL || !allocate(swarm, mj, model)) {
    return refuse(swarm, mj);
  }
  bind_all(swarm, mj, model);
  map_bodies(swarm, model);
  measure_reach(swarm, model);
  number_things(swarm, model);
  if (!cf_downwash_new(swarm) || !cf_looking_new(swarm, model)) {
    return refuse(swarm, mj);
  }
  return swarm;
}

void cf_swarm_free(swarm_t *swarm) {
  free(swarm->drones);
  free(swarm->configs);
  free(swarm->work);
  free(swarm->touched);
  free(swarm->in_contact);
  free(swarm->drone_of_body);
  free(swarm->thing_of_geom);
  free(swarm->collisions);
  cf_scenery_free(swarm->scenery);
  cf_looking_free(swarm);
  cf_peer_grid_free(&swarm->peers);
  cf_downwash_free(swarm);
  free(swarm);
}

swarm_t *cf_swarm_of(const mjModel *model, const mjData *data) {
  for (int i = 0; i < model->nplugin; i++) {
    if (cf_swarm_has(model, i) && data->plugin_data[i] != 0) {
      return ((drone_t *)data->plugin_data[i])->swarm;
    }
  }
  return NULL;
}

const drone_t *cf_swarm_drone_of_body(const mjModel *model, const mjData *data, int body) {
  const int root     = model->body_rootid[body];
  const int instance = model->body_plugin[root];
  if (instance < 0 || !cf_swarm_has(model, instance)) {
    return NULL;
  }
  const drone_t *drone = (const drone_t *)data->plugin_data[instance];
  return drone != NULL && drone->body == root ? drone : NULL;
}

drone_t *cf_swarm_find(swarm_t *swarm, int instance) {
  for (int i = 0; i < swarm->count; i++) {
    if (swarm->drones[i].instance == instance) {
      return &swarm->drones[i];
    }
  }
  return NULL;
}

void cf_swarm_check_timestep(const cf_mujoco_api_t *mj, double timestep) {
  const double ratio  = timestep > TICK ? timestep / TICK : TICK / timestep;
  const double excess = fabs(ratio - nearbyint(ratio));
  if (!(timestep > 0) || !(ratio <= 20) || excess > 1e-6) {
    mj->error(
        "crazyflie: option timestep is %g s, allowed: 0.001 s times or divided by a whole "
        "number up to 20",
        timestep);
  }
}
