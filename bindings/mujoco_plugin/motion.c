#include "mujoco_plugin/motion.h"

#include <math.h>
#include <string.h>

#define WAKE_VELOCITY 1e-9  // [m/s], enough for MuJoCo to wake a sleeping tree
#define WAKE_THRUST 1e-3f   // [N], a rotor that pushes harder wakes the drone

cf_t *cf_state_of(const drone_t *drone, mjData *data) {
  return (cf_t *)(data->plugin_state + drone->state_address);
}

static void rotation_of(const double quat[4], double r[9]) {
  const double w = quat[0], x = quat[1], y = quat[2], z = quat[3];
  r[0] = 1 - 2 * (y * y + z * z);
  r[1] = 2 * (x * y - w * z);
  r[2] = 2 * (x * z + w * y);
  r[3] = 2 * (x * y + w * z);
  r[4] = 1 - 2 * (x * x + z * z);
  r[5] = 2 * (y * z - w * x);
  r[6] = 2 * (x * z - w * y);
  r[7] = 2 * (y * z + w * x);
  r[8] = 1 - 2 * (x * x + y * y);
}

void cf_motion_of(const drone_t *drone, const mjData *data, cf_motion_t *motion) {
  const double *pose  = data->qpos + drone->qpos_address;
  const double *twist = data->qvel + drone->dof_address;
  for (int i = 0; i < 3; i++) {
    motion->position[i] = (float)pose[i];
    motion->velocity[i] = (float)twist[i];
    motion->rates[i]    = (float)twist[3 + i];
  }
  for (int i = 0; i < 4; i++) {
    motion->quat_wxyz[i] = (float)pose[3 + i];
  }
  double rotation[9];
  rotation_of(pose + 3, rotation);
  for (int i = 0; i < 9; i++) {
    motion->rotation[i] = (float)rotation[i];
  }
}

// Mean specific force over the time since the last sample: R^T ((v+ - v-) / h - g), right for every
// integrator (vehicle dossier section 12.5).
static void specific_force_of(const drone_t *drone, const mjModel *model, const mjData *data,
                              const cf_t *cf, double elapsed, cf_motion_t *motion) {
  const double *now = data->qvel + drone->dof_address;
  float         force[3];
  for (int i = 0; i < 3; i++) {
    const double before = cf->has_last_velocity ? cf->last_velocity[i] : now[i];
    force[i]            = (float)((now[i] - before) / elapsed - model->opt.gravity[i]);
  }
  const float *r = motion->rotation;
  for (int i = 0; i < 3; i++) {
    motion->specific_force[i] = r[i] * force[0] + r[3 + i] * force[1] + r[6 + i] * force[2];
  }
}

static bool is_finite_state(const drone_t *drone, const mjData *data) {
  double sum = 0;
  for (int i = 0; i < 7; i++) {
    sum += fabs(data->qpos[drone->qpos_address + i]);
  }
  for (int i = 0; i < 6; i++) {
    sum += fabs(data->qvel[drone->dof_address + i]);
  }
  return sum < 1e10;  // false for NaN as well
}

// A drone whose motion is no number would spoil the collision detection of all: it goes back to its
// start pose and stays there, locked.
static void park(const drone_t *drone, const mjModel *model, mjData *data) {
  memcpy(data->qpos + drone->qpos_address, model->qpos0 + drone->qpos_address, 7 * sizeof(mjtNum));
  memset(data->qvel + drone->dof_address, 0, 6 * sizeof(mjtNum));
  memset(data->qacc_warmstart + drone->dof_address, 0, 6 * sizeof(mjtNum));
}

static void wake_if_thrusting(const drone_t *drone, mjData *data, const cf_t *cf) {
  const bool is_asleep = data->tree_asleep[drone->tree] >= 0;
  if (is_asleep && cf_rotors_total_thrust(&cf->vehicle.rotors) > WAKE_THRUST) {
    data->qvel[drone->dof_address + 2] = WAKE_VELOCITY;
  }
}

void cf_motion_sample(const drone_t *drone, const mjModel *model, mjData *data, double elapsed,
                      cf_motion_t *motion) {
  cf_t *cf = cf_state_of(drone, data);
  cf_motion_of(drone, data, motion);
  specific_force_of(drone, model, data, cf, elapsed, motion);
  if (!is_finite_state(drone, data)) {
    park(drone, model, data);
  }
  wake_if_thrusting(drone, data, cf);
  memcpy(cf->last_velocity, data->qvel + drone->dof_address, sizeof cf->last_velocity);
  cf->has_last_velocity = true;
}
