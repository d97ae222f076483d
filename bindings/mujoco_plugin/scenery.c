#include "mujoco_plugin/scenery.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_plugin/box_tree.h"
#include "mujoco_plugin/rotation.h"

typedef struct {
  double normal[3];
  double offset;  // [m], along the normal
} plane_t;

typedef struct {
  double position[3];
  double rotation[9];  // row-major
} pose_t;

struct cf_scenery_s {
  const cf_mujoco_api_t *mj;
  const mjModel         *model;

  int           plane_count;
  plane_t      *planes;
  int           solid_count;
  int32_t      *solids;  // geoms
  pose_t       *poses;   // of the solids
  cf_box_tree_t tree;

  // MuJoCo's functions for meshes and height fields look up the pose of a geom in mjData. The real
  // one changes while drones look; this one holds poses of what does not move and nothing else.
  mjData *still;
};

bool cf_scenery_is_static(const mjModel *model, int body) {
  // mocap bodies are children of the world
  return model->body_treeid[body] < 0 && model->body_mocapid[model->body_rootid[body]] < 0;
}

// ------------------------------------------------------------------------------------------ poses

// pose := (position, quat) seen from a parent, followed by pose
static void prepend(const double position[3], const double quat[4], pose_t *pose) {
  double       r[9];
  const pose_t inner = *pose;
  cf_rotation_of(quat, r);
  for (int i = 0; i < 3; i++) {
    pose->position[i] = position[i];
    for (int k = 0; k < 3; k++) {
      pose->position[i] += r[3 * i + k] * inner.position[k];
      pose->rotation[3 * i + k] = 0;
      for (int j = 0; j < 3; j++) {
        pose->rotation[3 * i + k] += r[3 * i + j] * inner.rotation[3 * j + k];
      }
    }
  }
}

// Where a geom of a body that never moves stands in the world.
static pose_t pose_of(const mjModel *model, int geom) {
  pose_t pose = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  prepend(model->geom_pos + 3 * geom, model->geom_quat + 4 * geom, &pose);
  for (int body = model->geom_bodyid[geom]; body > 0; body = model->body_parentid[body]) {
    prepend(model->body_pos + 3 * body, model->body_quat + 4 * body, &pose);
  }
  return pose;
}

static cf_box_t box_of(const mjModel *model, int geom, const pose_t *pose) {
  const double *local = model->geom_aabb + 6 * geom;  // center, half sizes
  cf_box_t      box;
  for (int i = 0; i < 3; i++) {
    double center = pose->position[i];
    double half   = 0;
    for (int k = 0; k < 3; k++) {
      center += pose->rotation[3 * i + k] * local[k];
      half += fabs(pose->rotation[3 * i + k]) * local[3 + k];
    }
    box.low[i]  = center - half;
    box.high[i] = center + half;
  }
  return box;
}

// ---------------------------------------------------------------------------------------- reading

static bool counts(const mjModel *model, int geom) {
  const bool collides = model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0;
  return collides && cf_scenery_is_static(model, model->geom_bodyid[geom]);
}

static bool needs_data(int type) {
  return type == mjGEOM_MESH || type == mjGEOM_HFIELD;
}

static bool has_ray(int type) {
  return needs_data(type) || type == mjGEOM_SPHERE || type == mjGEOM_CAPSULE ||
         type == mjGEOM_ELLIPSOID || type == mjGEOM_CYLINDER || type == mjGEOM_BOX;
}

static void add_plane(cf_scenery_t *scenery, const pose_t *pose) {
  plane_t *plane = &scenery->planes[scenery->plane_count++];
  for (int k = 0; k < 3; k++) {
    plane->normal[k] = pose->rotation[3 * k + 2];
    plane->offset += plane->normal[k] * pose->position[k];
  }
}

static void keep_pose_for_mujoco(cf_scenery_t *scenery, int geom, const pose_t *pose) {
  memcpy(scenery->still->geom_xpos + 3 * geom, pose->position, sizeof pose->position);
  memcpy(scenery->still->geom_xmat + 9 * geom, pose->rotation, sizeof pose->rotation);
}

static bool make_still(cf_scenery_t *scenery) {
  mjData *still = calloc(1, sizeof *still);
  if (still == NULL) {
    return false;
  }
  still->geom_xpos = calloc(3 * (size_t)scenery->model->ngeom, sizeof(mjtNum));
  still->geom_xmat = calloc(9 * (size_t)scenery->model->ngeom, sizeof(mjtNum));
  scenery->still   = still;
  return still->geom_xpos != NULL && still->geom_xmat != NULL;
}

static bool read_geoms(cf_scenery_t *scenery, cf_box_t *boxes) {
  const mjModel *model = scenery->model;
  for (int geom = 0; geom < model->ngeom; geom++) {
    const int type = model->geom_type[geom];
    if (!counts(model, geom)) {
      continue;
    }
    const pose_t pose = pose_of(model, geom);
    if (type == mjGEOM_PLANE) {
      add_plane(scenery, &pose);
    } else if (has_ray(type)) {
      if (needs_data(type)) {
        if (scenery->still == NULL && !make_still(scenery)) {
          return false;
        }
        keep_pose_for_mujoco(scenery, geom, &pose);
      }
      boxes[scenery->solid_count]           = box_of(model, geom, &pose);
      scenery->poses[scenery->solid_count]  = pose;
      scenery->solids[scenery->solid_count] = geom;
      scenery->solid_count++;
    }
  }
  return true;
}

cf_scenery_t *cf_scenery_new(const cf_mujoco_api_t *mj, const mjModel *model) {
  size_t room = 1;  // an allocation of nothing may be null
  for (int geom = 0; geom < model->ngeom; geom++) {
    room += counts(model, geom);
  }
  cf_scenery_t *scenery = calloc(1, sizeof *scenery);
  cf_box_t     *boxes   = calloc(room, sizeof *boxes);
  bool          is_done = false;
  if (scenery != NULL && boxes != NULL) {
    scenery->mj     = mj;
    scenery->model  = model;
    scenery->planes = calloc(room, sizeof *scenery->planes);
    scenery->poses  = calloc(room, sizeof *scenery->poses);
    scenery->solids = calloc(room, sizeof *scenery->solids);
    is_done = scenery->planes != NULL && scenery->poses != NULL && scenery->solids != NULL &&
              read_geoms(scenery, boxes) &&
              cf_box_tree_new(&scenery->tree, boxes, scenery->solid_count);
  }
  free(boxes);
  if (!is_done) {
    cf_scenery_free(scenery);
    return NULL;
  }
  return scenery;
}

void cf_scenery_free(cf_scenery_t *scenery) {
  if (scenery == NULL) {
    return;
  }
  if (scenery->still != NULL) {
    free(scenery->still->geom_xpos);
    free(scenery->still->geom_xmat);
    free(scenery->still);
  }
  cf_box_tree_free(&scenery->tree);
  free(scenery->planes);
  free(scenery->poses);
  free(scenery->solids);
  free(scenery);
}

// ----------------------------------------------------------------------------------------- asking

bool cf_scenery_is_flat_floor(const cf_scenery_t *scenery) {
  const plane_t *floor = scenery->planes;
  return scenery->solid_count == 0 && scenery->plane_count == 1 && floor->normal[2] == 1.0 &&
         floor->offset == 0.0;
}

static double ray_to_plane(const plane_t *plane, const double point[3], const double direction[3]) {
  double height = -plane->offset;
  double sink   = 0;
  for (int k = 0; k < 3; k++) {
    height += plane->normal[k] * point[k];
    sink -= plane->normal[k] * direction[k];
  }
  return height >= 0 && sink > 0 ? height / sink : (double)INFINITY;
}

typedef struct {
  const cf_scenery_t *scenery;
  double              point[3];
  double              direction[3];
} ray_t;

static double meet(const void *context, int solid, double reach) {
  const ray_t        *ray     = context;
  const cf_scenery_t *scenery = ray->scenery;
  const mjModel      *model   = scenery->model;
  const int           geom    = scenery->solids[solid];
  const int           type    = model->geom_type[geom];
  double              distance;
  if (type == mjGEOM_MESH) {
    distance = scenery->mj->ray_mesh(model, scenery->still, geom, ray->point, ray->direction, NULL);
  } else if (type == mjGEOM_HFIELD) {
    distance =
        scenery->mj->ray_hfield(model, scenery->still, geom, ray->point, ray->direction, NULL);
  } else {
    const pose_t *pose = &scenery->poses[solid];
    distance = scenery->mj->ray_geom(pose->position, pose->rotation, model->geom_size + 3 * geom,
                                     ray->point, ray->direction, type, NULL);
  }
  return distance >= 0 ? distance : reach;
}

float cf_scenery_ray(const cf_scenery_t *scenery, const float point[3], const float direction[3],
                     float reach) {
  ray_t ray = {.scenery = scenery};
  for (int k = 0; k < 3; k++) {
    ray.point[k]     = (double)point[k];
    ray.direction[k] = (double)direction[k];
  }
  double nearest = (double)reach;
  for (int i = 0; i < scenery->plane_count; i++) {
    nearest = fmin(nearest, ray_to_plane(&scenery->planes[i], ray.point, ray.direction));
  }
  nearest = cf_box_tree_ray(&scenery->tree, ray.point, ray.direction, nearest, meet, &ray);
  return (float)nearest;
}

float cf_scenery_height_below(const cf_scenery_t *scenery, const float point[3], float reach) {
  static const float DOWN[3] = {0.0f, 0.0f, -1.0f};
  return cf_scenery_ray(scenery, point, DOWN, reach);
}
