#include "mujoco_plugin/motion.h"

#include <math.h>
#include <string.h>

#include "mujoco_plugin/rotation.h"

#define MIN_CHANGE 0.02     // [rad/s] in a step
#define LARGEST_CHANGE 5.0  // [rad/s] in a step, beyond it something has hit the drone
#define SHORT_STEP 0.0009   // [s], with shorter ones there are several in a tick
#define WAKE_VELOCITY 1e-9  // [m/s], enough for MuJoCo to wake a sleeping tree
#define WAKE_THRUST 1e-3f   // [N], a rotor that pushes harder wakes the drone

cf_t *cf_state_of(const drone_t *drone, mjData *data) {
  return (cf_t *)(data->plugin_state + drone->state_address);
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
  cf_rotation_of(pose + 3, rotation);
  for (int i = 0; i < 9; i++) {
    motion->rotation[i] = (float)rotation[i];
  }
}

// Mean specific force over the time since the last sample: R^T ((v+ - v-) / h - g), right for every
// integrator (docs/reference/vehicle.md#12.5).
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

// MuJoCo's Euler step turns a body by the rates at its end. The mean of both ends is what happened:
// turn it back by half of their difference, q <- q exp(-h/2 (w+ - w-)). Worth its time in a tumble
// only; when it flies by itself, a drone's rates change by less in a step.
static void turn_by_mean_rates(const drone_t *drone, const mjModel *model, mjData *data,
                               const cf_t *cf) {
  const double *w      = data->qvel + drone->dof_address + 3;
  const double *before = cf->last_rates;
  const double  d[3]   = {w[0] - before[0], w[1] - before[1], w[2] - before[2]};
  const double  change = fabs(d[0]) + fabs(d[1]) + fabs(d[2]);
  if (!cf->has_last_velocity || !(change > MIN_CHANGE && change < LARGEST_CHANGE)) {
    return;
  }
  double      *q    = data->qpos + drone->qpos_address + 3;
  const double half = -0.25 * model->opt.timestep;
  const double x = half * d[0], y = half * d[1], z = half * d[2];
  const double a = q[0], b = q[1], c = q[2], e = q[3];
  const double s = 1.0 / sqrt(1.0 + x * x + y * y + z * z);
  q[0]           = s * (a - b * x - c * y - e * z);
  q[1]           = s * (b + a * x + c * z - e * y);
  q[2]           = s * (c + a * y + e * x - b * z);
  q[3]           = s * (e + a * z + b * y - c * x);
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
  // a held drone has been stopped and put back since the step: this would rotate it off its pose
  if (model->opt.integrator == mjINT_EULER && model->opt.timestep > SHORT_STEP &&
      !cf->rest.is_held) {
    turn_by_mean_rates(drone, model, data, cf);
  }
  cf_motion_of(drone, data, motion);
  specific_force_of(drone, model, data, cf, elapsed, motion);
  if (!is_finite_state(drone, data)) {
    park(drone, model, data);
  }
  wake_if_thrusting(drone, data, cf);
  memcpy(cf->last_velocity, data->qvel + drone->dof_address, sizeof cf->last_velocity);
  memcpy(cf->last_rates, data->qvel + drone->dof_address + 3, sizeof cf->last_rates);
  cf->has_last_velocity = true;
}
