#define _POSIX_C_SOURCE 200809L  // sched_yield
#include "mujoco_plugin/looking.h"

#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_plugin/rotation.h"
#include "mujoco_plugin/scenery.h"
#include "mujoco_plugin/swarm.h"

enum { GRID_OLD, GRID_BUSY, GRID_READY };

// A Crazyflie is small and dark. How far the chip sees one is not established; 2 m is a guess, and
// keeps the search short.
static const double PEER_REACH = 2.0;  // [m]

// --------------------------------------------------------------------------------------- building

static bool collides(const mjModel *model, int geom) {
  return model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0;
}

// Whether MuJoCo can tell from its pose and size where a ray meets a geom; of planes and height
// fields, which have no end, nothing moves.
static bool is_simple(int type) {
  return type != mjGEOM_MESH && type != mjGEOM_SDF && type != mjGEOM_PLANE && type != mjGEOM_HFIELD;
}

// The geoms of a body stand in a row.
static cf_hull_t hull_of(const mjModel *model, int body) {
  cf_hull_t hull = {.first = model->body_geomadr[body], .count = model->body_geomnum[body]};
  for (int geom = hull.first; geom < hull.first + hull.count; geom++) {
    if (collides(model, geom)) {
      const double *p = model->geom_pos + 3 * geom;
      const double  r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) + model->geom_rbound[geom];
      hull.radius     = fmax(hull.radius, r);
    }
  }
  return hull;
}

// A body that hangs on a drone by joints is no mover either: ranging sensors do not detect it.
static bool is_mover(const swarm_t *swarm, const mjModel *model, int geom) {
  const int body = model->geom_bodyid[geom];
  const int type = model->geom_type[geom];
  return collides(model, geom) && !cf_scenery_is_static(model, body) &&
         swarm->drone_of_body[body] < 0 && (is_simple(type) || type == mjGEOM_MESH);
}

static bool has_ranger(const cf_config_t *config) {
  const cf_vehicle_config_t *vehicle = &config->vehicle;
  return vehicle->positioning == CF_POSITIONING_FLOW || vehicle->rangers.has_zranger ||
         vehicle->rangers.has_multiranger;
}

static float distance(const cf_surroundings_t *self, const float point[3], const float direction[3],
                      float cone, float reach) {
  const cf_view_t *view = (const cf_view_t *)(const void *)self;
  return cf_looking_distance(view->swarm, view->self, point, direction, cone, reach);
}

// What hangs on a drone's hook is beside its decks, and does not blind them.
static int hook_of(const swarm_t *swarm, const mjModel *model, int geom) {
  const int body = model->geom_bodyid[geom];
  for (int eq = 0; eq < model->neq; eq++) {
    const int a = model->eq_obj1id[eq];
    const int b = model->eq_obj2id[eq];
    if (model->eq_type[eq] == mjEQ_WELD && model->eq_objtype[eq] == mjOBJ_BODY &&
        ((a == body && swarm->drone_of_body[b] >= 0) ||
         (b == body && swarm->drone_of_body[a] >= 0))) {
      return eq;
    }
  }
  return -1;
}

static bool is_carried(const swarm_t *swarm, int hook, int drone) {
  const mjModel *model = swarm->model;
  return hook >= 0 && drone >= 0 && swarm->data->eq_active[hook] != 0 &&
         (swarm->drone_of_body[model->eq_obj1id[hook]] == drone ||
          swarm->drone_of_body[model->eq_obj2id[hook]] == drone);
}

static bool new_movers(swarm_t *swarm, const mjModel *model) {
  cf_looking_t *looking = &swarm->looking;
  looking->movers       = calloc((size_t)model->ngeom + 1, sizeof *looking->movers);
  looking->hooks        = calloc((size_t)model->ngeom + 1, sizeof *looking->hooks);
  if (looking->movers == NULL || looking->hooks == NULL) {
    return false;
  }
  for (int geom = 0; geom < model->ngeom; geom++) {
    if (is_mover(swarm, model, geom)) {
      looking->hooks[looking->mover_count]    = hook_of(swarm, model, geom);
      looking->movers[looking->mover_count++] = geom;
    }
  }
  if (looking->mover_count == 0) {
    return true;
  }
  looking->posed = calloc(1, sizeof *looking->posed);
  if (looking->posed == NULL) {
    return false;
  }
  looking->posed->geom_xpos = calloc(3 * (size_t)model->ngeom, sizeof(mjtNum));
  looking->posed->geom_xmat = calloc(9 * (size_t)model->ngeom, sizeof(mjtNum));
  return looking->posed->geom_xpos != NULL && looking->posed->geom_xmat != NULL;
}

bool cf_looking_new(swarm_t *swarm, const mjModel *model) {
  cf_looking_t *looking = &swarm->looking;
  looking->views        = calloc((size_t)swarm->count, sizeof *looking->views);
  looking->hulls        = calloc((size_t)swarm->count, sizeof *looking->hulls);
  if (looking->views == NULL || looking->hulls == NULL || !new_movers(swarm, model) ||
      !cf_peer_grid_new(&looking->grid, swarm->count)) {
    return false;
  }
  const bool is_plain = cf_scenery_is_flat_floor(swarm->scenery) && looking->mover_count == 0;
  for (int i = 0; i < swarm->count; i++) {
    looking->hulls[i]   = hull_of(model, swarm->drones[i].body);
    looking->widest     = fmax(looking->widest, looking->hulls[i].radius);
    looking->views[i]   = (cf_view_t){.base = {.distance = distance}, .swarm = swarm, .self = i};
    const bool is_alone = swarm->count == 1 || swarm->drones[i].is_isolated;
    if (!(is_plain && is_alone) && has_ranger(swarm->drones[i].config)) {
      looking->is_needed                 = true;
      swarm->work[i].motion.surroundings = &looking->views[i].base;
    }
  }
  return true;
}

void cf_looking_free(swarm_t *swarm) {
  cf_looking_t *looking = &swarm->looking;
  if (looking->posed != NULL) {
    free(looking->posed->geom_xpos);
    free(looking->posed->geom_xmat);
  }
  free(looking->posed);
  free(looking->movers);
  free(looking->hooks);
  free(looking->views);
  free(looking->hulls);
  cf_peer_grid_free(&looking->grid);
}

// --------------------------------------------------------------------------------------- the grid

void cf_looking_begin(swarm_t *swarm, const mjData *data) {
  cf_looking_t *looking = &swarm->looking;
  atomic_store_explicit(&looking->grid_state, GRID_OLD, memory_order_relaxed);
  for (int i = 0; i < looking->mover_count; i++) {
    const int geom = looking->movers[i];
    memcpy(looking->posed->geom_xpos + 3 * geom, data->geom_xpos + 3 * geom, 3 * sizeof(mjtNum));
    memcpy(looking->posed->geom_xmat + 9 * geom, data->geom_xmat + 9 * geom, 9 * sizeof(mjtNum));
  }
}

// The first calling thread sorts, the others wait. The result is the same for every thread, because
// it depends on positions only.
static const cf_peer_grid_t *grid_of(swarm_t *swarm) {
  cf_looking_t *looking = &swarm->looking;
  int           state   = GRID_OLD;
  if (atomic_load_explicit(&looking->grid_state, memory_order_acquire) == GRID_READY) {
    return &looking->grid;
  }
  if (atomic_compare_exchange_strong(&looking->grid_state, &state, GRID_BUSY)) {
    cf_peer_grid_clear(&looking->grid);
    for (int i = 0; i < swarm->count; i++) {
      if (!swarm->drones[i].is_isolated) {
        cf_peer_grid_add(&looking->grid, i, swarm->work[i].motion.position);
      }
    }
    cf_peer_grid_sort(&looking->grid);
    atomic_store_explicit(&looking->grid_state, GRID_READY, memory_order_release);
  }
  while (atomic_load_explicit(&looking->grid_state, memory_order_acquire) != GRID_READY) {
    sched_yield();
  }
  return &looking->grid;
}

// ------------------------------------------------------------------------------------------- rays

typedef struct {
  swarm_t *swarm;
  int      self;
  double   point[3];
  double   direction[3];
  double   cone;  // cosine
  double   nearest;
} search_t;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Whether a ray passes a ball nearer than the nearest so far; `center` is seen from the point.
static bool may_meet(const search_t *search, const double direction[3], const double center[3],
                     double radius) {
  const double along  = dot(center, direction);
  const double aside2 = dot(center, center) - along * along;
  return along > -radius && along - radius < search->nearest && aside2 <= radius * radius;
}

static void keep_nearer(search_t *search, double distance) {
  if (distance >= 0 && distance < search->nearest) {
    search->nearest = distance;
  }
}

static void look_at_movers(search_t *search) {
  const swarm_t      *swarm   = search->swarm;
  const cf_looking_t *looking = &swarm->looking;
  const mjModel      *model   = swarm->model;
  for (int i = 0; i < looking->mover_count; i++) {
    const int     geom     = looking->movers[i];
    const int     type     = model->geom_type[geom];
    const double *position = looking->posed->geom_xpos + 3 * geom;
    const double *rotation = looking->posed->geom_xmat + 9 * geom;
    double        center[3];
    for (int k = 0; k < 3; k++) {
      center[k] = position[k] - search->point[k];
    }
    if (!may_meet(search, search->direction, center, model->geom_rbound[geom]) ||
        is_carried(swarm, looking->hooks[i], search->self)) {
      continue;
    }
    keep_nearer(search, type == mjGEOM_MESH
                            ? swarm->mj->ray_mesh(model, looking->posed, geom, search->point,
                                                  search->direction, NULL)
                            : swarm->mj->ray_geom(position, rotation, model->geom_size + 3 * geom,
                                                  search->point, search->direction, type, NULL));
  }
}

// The ray in the frame of a drone's body, where its geoms stand still.
static void look_at_hull(search_t *search, int drone, const double direction[3]) {
  const swarm_t   *swarm  = search->swarm;
  const mjModel   *model  = swarm->model;
  const cf_hull_t *hull   = &swarm->looking.hulls[drone];
  const float     *r      = swarm->work[drone].motion.rotation;
  const float     *origin = swarm->work[drone].motion.position;
  double           point[3], ray[3];
  for (int k = 0; k < 3; k++) {
    point[k] = 0;
    ray[k]   = 0;
    for (int j = 0; j < 3; j++) {
      point[k] += (double)r[3 * j + k] * (search->point[j] - (double)origin[j]);
      ray[k] += (double)r[3 * j + k] * direction[j];
    }
  }
  for (int geom = hull->first; geom < hull->first + hull->count; geom++) {
    const int type = model->geom_type[geom];
    if (collides(model, geom) && is_simple(type)) {
      double rotation[9];
      cf_rotation_of(model->geom_quat + 4 * geom, rotation);
      keep_nearer(search, swarm->mj->ray_geom(model->geom_pos + 3 * geom, rotation,
                                              model->geom_size + 3 * geom, point, ray, type, NULL));
    }
  }
}

static void look_at_drone(search_t *search, const cf_seen_drone_t *drone) {
  if (drone->index == search->self) {
    return;
  }
  double center[3];
  for (int k = 0; k < 3; k++) {
    center[k] = (double)drone->position[k] - search->point[k];
  }
  const double radius = search->swarm->looking.hulls[drone->index].radius;
  if (may_meet(search, search->direction, center, radius)) {
    look_at_hull(search, drone->index, search->direction);
  }
  // beside the axis, but within the cone
  const double distance = sqrt(dot(center, center));
  const bool   is_near  = distance > radius && distance - radius < search->nearest;
  if (is_near && dot(center, search->direction) > search->cone * distance) {
    const double toward[3] = {center[0] / distance, center[1] / distance, center[2] / distance};
    look_at_hull(search, drone->index, toward);
  }
}

static int32_t column_of(double coordinate) {
  return (int32_t)floor(coordinate);
}

// Searches all columns with drones that the cone passes through.
static void look_at_drones(search_t *search, const cf_peer_grid_t *grid) {
  const double reach = fmin(search->nearest, PEER_REACH);
  const double sine  = sqrt(fmax(0.0, 1.0 - search->cone * search->cone));
  const double wide  = reach * sine / search->cone + search->swarm->looking.widest;
  int32_t      low[2], high[2];
  for (int k = 0; k < 2; k++) {
    const double start = search->point[k];
    const double end   = start + reach * search->direction[k];
    low[k]             = column_of(fmax(fmin(start, end) - wide, (double)grid->low[k]));
    high[k]            = column_of(fmin(fmax(start, end) + wide, (double)grid->high[k]));
  }
  const double beyond = search->nearest;
  search->nearest     = reach;
  for (int32_t x = low[0]; x <= high[0]; x++) {
    for (int32_t y = low[1]; y <= high[1]; y++) {
      const cf_seen_drone_t *drones;
      const int              count = cf_peer_grid_bucket(grid, x, y, &drones);
      for (int i = 0; i < count; i++) {
        if (drones[i].column[0] == x && drones[i].column[1] == y) {
          look_at_drone(search, &drones[i]);
        }
      }
    }
  }
  search->nearest = search->nearest < reach ? search->nearest : beyond;
}

float cf_looking_distance(swarm_t *swarm, int self, const float point[3], const float direction[3],
                          float cone, float reach) {
  search_t search = {.swarm   = swarm,
                     .self    = self,
                     .cone    = (double)cone,
                     .nearest = (double)cf_scenery_ray(swarm->scenery, point, direction, reach)};
  for (int k = 0; k < 3; k++) {
    search.point[k]     = (double)point[k];
    search.direction[k] = (double)direction[k];
  }
  look_at_movers(&search);
  const bool has_company = self < 0 || !swarm->drones[self].is_isolated;
  if (swarm->count > 1 && has_company) {
    const cf_peer_grid_t *grid = grid_of(swarm);
    if (grid->count > 0) {
      look_at_drones(&search, grid);
    }
  }
  return (float)search.nearest;
}
