#include "mujoco_plugin/sleep.h"

#include <math.h>
#include <string.h>

#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/rotation.h"
#include "mujoco_plugin/touch.h"

// A drone is still below these. A single one stands with 1e-15 m/s. Heaps creep with 1 to 5 mm/s
// and up to 0.1 rad/s, because friction is a soft constraint, and some in them rock for seconds.
#define STILL_SPEED 0.01       // [m/s]
#define STILL_RATE 0.2         // [rad/s]
#define STILL_TIME 0.5f        // [s] until it is held
#define FALL_TIME 0.1f         // [s] until one is held again that a neighbor has left
#define STILL_FACTOR_HEAP 3.0  // for one that touches another drone

// Or it rocks, but stays where it is.
#define PLACE 5e-3        // [m]
#define PLACE_TURN 0.03   // of the quaternion, 3.4 deg
#define PLACED_TIME 2.0f  // [s] until it is held

// Rotors and wind that push with more than this share of the weight let a drone go. Friction keeps
// a landed drone in place up to 60 %.
#define MIN_PUSH 0.02

// What moves an untouched drone by more than rounding is a push. Drones that lie on another push it
// all the time, there only a blow counts: the weight of six, or a hit by one at 0.15 m/s.
#define ROUNDING 1e-9     // [m/s], [rad/s], [m]
#define MIN_BLOW 60.0     // [m/s^2]
#define MIN_TWIST 3000.0  // [rad/s^2], three of them at a corner

// A drone that was let go leaves its place when it is this far away and not slow. A heap creeps at
// a few mm/s: if that were enough, its drones would wake each other without end.
#define MIN_DISPLACEMENT 1e-3  // [m]

// Every number within the limit; false for NaN.
static bool are_within(const double *numbers, int count, double limit) {
  bool within = true;
  for (int i = 0; i < count; i++) {
    within = within && fabs(numbers[i]) <= limit;
  }
  return within;
}

static bool is_at(const double pose[7], const double now[7], double limit, double limit_turn) {
  bool within = true;
  for (int i = 0; i < 7; i++) {
    within = within && fabs(now[i] - pose[i]) <= (i < 3 ? limit : limit_turn);
  }
  return within;
}

bool cf_sleep_is_awake(const drone_t *drone, mjData *data) {
  const cf_t *cf = cf_state_of(drone, data);
  return !drone->can_sleep ||
         (double)cf_rotors_total_thrust(&cf->vehicle.rotors) > MIN_PUSH * drone->weight;
}

// By rotors, wind, and whatever else acts through the air.
static bool is_pushed(const drone_t *drone, mjData *data) {
  cf_motion_t motion;
  float       force[3];
  float       torque[3];
  cf_motion_of(drone, data, &motion);
  cf_wrench(cf_state_of(drone, data), &motion, force, torque);
  const float square = force[0] * force[0] + force[1] * force[1] + force[2] * force[2];
  return (double)sqrtf(square) > MIN_PUSH * drone->weight;
}

static bool is_slow(const drone_t *drone, const mjData *data, double factor) {
  const double *twist = data->qvel + drone->dof_address;
  return are_within(twist, 3, factor * STILL_SPEED) &&
         are_within(twist + 3, 3, factor * STILL_RATE);
}

static void let_go(cf_sleep_t *sleep, float still_time) {
  sleep->is_held     = false;
  sleep->is_loose    = true;
  sleep->still_time  = still_time;
  sleep->placed_time = 0.0f;
}

static void keep_in_place(const drone_t *drone, mjData *data, const cf_sleep_t *sleep) {
  memcpy(data->qpos + drone->qpos_address, sleep->pose, sizeof sleep->pose);
  memset(data->qvel + drone->dof_address, 0, 6 * sizeof(mjtNum));
  memset(data->qacc_warmstart + drone->dof_address, 0, 6 * sizeof(mjtNum));
}

static void hold(const drone_t *drone, mjData *data, cf_sleep_t *sleep) {
  memcpy(sleep->pose, data->qpos + drone->qpos_address, sizeof sleep->pose);
  memset(sleep->load, 0, sizeof sleep->load);
  sleep->is_held    = true;
  sleep->is_loose   = false;
  sleep->is_weighed = false;
  keep_in_place(drone, data, sleep);
}

// Counts for how long it has been slow, and for how long at one place.
static void hold_if_still(const drone_t *drone, mjData *data, cf_sleep_t *sleep, uint8_t touched,
                          double elapsed) {
  const double factor = touched == CF_TOUCH_NONE ? 1.0 : STILL_FACTOR_HEAP;
  sleep->still_time   = is_slow(drone, data, factor) ? sleep->still_time + (float)elapsed : 0.0f;
  if (is_at(sleep->pose, data->qpos + drone->qpos_address, PLACE, PLACE_TURN)) {
    sleep->placed_time += (float)elapsed;
  } else {
    memcpy(sleep->pose, data->qpos + drone->qpos_address, sizeof sleep->pose);
    sleep->placed_time = 0.0f;
  }
  if ((sleep->still_time >= STILL_TIME || sleep->placed_time >= PLACED_TIME) &&
      !is_pushed(drone, data)) {
    hold(drone, data, sleep);
  }
}

// A hand has put a held drone elsewhere: farther than its velocity leads in this time [s].
static bool is_displaced(const drone_t *drone, mjData *data, double elapsed) {
  const cf_sleep_t *sleep = &cf_state_of(drone, data)->rest;
  const double     *pose  = data->qpos + drone->qpos_address;
  if (!sleep->is_held || memcmp(pose, sleep->pose, sizeof sleep->pose) == 0) {
    return false;
  }
  const double *twist = data->qvel + drone->dof_address;
  double        speed = 0;
  double        rate  = 0;
  for (int i = 0; i < 3; i++) {
    speed += fabs(twist[i]);
    rate += fabs(twist[3 + i]);
  }
  bool is_near = true;
  for (int i = 0; i < 7; i++) {
    const double reach = ROUNDING + (i < 3 ? speed : rate) * elapsed;
    is_near            = is_near && fabs(pose[i] - sleep->pose[i]) <= reach;
  }
  return !is_near;
}

bool cf_sleep_has_left(const drone_t *drone, mjData *data, double elapsed) {
  const cf_sleep_t *sleep = &cf_state_of(drone, data)->rest;
  if (sleep->is_held || sleep->placed_time == 0.0f) {
    return is_displaced(drone, data, elapsed);
  }
  const double  limit = sleep->is_loose ? MIN_DISPLACEMENT : PLACE;
  const double *now   = data->qpos + drone->qpos_address;
  return !is_at(sleep->pose, now, limit, PLACE_TURN) && !is_slow(drone, data, STILL_FACTOR_HEAP);
}

// Something acts on a drone from outside of the heap.
static bool is_disturbed(const drone_t *drone, mjData *data, const cf_sleep_t *sleep,
                         uint8_t touched, double elapsed) {
  const bool is_bare = touched == CF_TOUCH_NONE && are_within(sleep->load, 6, 0.0);
  return touched >= CF_TOUCH_LEFT || is_displaced(drone, data, elapsed) ||
         (is_bare && !are_within(data->qvel + drone->dof_address, 6, ROUNDING)) ||
         is_pushed(drone, data);
}

// A blow comes from one step to the next. What only grows heavy is carried: those at the bottom of
// a heap would else be let go as soon as they are held, with all of the others on them.
static bool is_hit(const drone_t *drone, const mjModel *model, const mjData *data,
                   const cf_sleep_t *sleep) {
  const double  mass    = model->body_mass[drone->body];
  const double *inertia = model->body_inertia + 3 * drone->body;
  const double *load    = data->qfrc_constraint + drone->dof_address;
  double        blow[6];
  for (int i = 0; i < 6; i++) {
    blow[i] = load[i] - sleep->load[i];
  }
  return sleep->is_weighed && (!are_within(blow, 3, MIN_BLOW * mass) ||
                               !are_within(blow + 3, 3, MIN_TWIST * fmin(inertia[0], inertia[1])));
}

void cf_sleep_step(const swarm_t *swarm, int i, const mjModel *model, mjData *data, double time,
                   double elapsed) {
  const drone_t *drone = &swarm->drones[i];
  cf_t          *cf    = cf_state_of(drone, data);
  cf_sleep_t    *sleep = &cf->rest;
  sleep->is_loose      = sleep->is_loose && !cf_sleep_has_left(drone, data, elapsed);
  if (!sleep->is_held && (swarm->touched[i] == CF_TOUCH_MOVER || cf_sleep_is_awake(drone, data))) {
    sleep->still_time  = 0.0f;
    sleep->placed_time = 0.0f;
  } else if (!sleep->is_held) {
    hold_if_still(drone, data, sleep, swarm->touched[i], elapsed);
  } else if (is_disturbed(drone, data, sleep, swarm->touched[i], elapsed)) {
    // a drone that has only lost a neighbor either falls at once or stays where it is
    let_go(sleep, swarm->touched[i] == CF_TOUCH_LEFT ? STILL_TIME - FALL_TIME : 0.0f);
  } else {
    sleep->is_weighed = sleep->is_weighed && swarm->touched[i] != CF_TOUCH_HELD;
    if (is_hit(drone, model, data, sleep)) {
      let_go(sleep, 0.0f);
      return;
    }
    memcpy(sleep->load, data->qfrc_constraint + drone->dof_address, sizeof sleep->load);
    sleep->is_weighed = true;
    keep_in_place(drone, data, sleep);
    cf_contacts_go_on(&cf->contacts, cf_contacts_clock(time),
                      cf->onboard.tick + (uint32_t)swarm->ticks);
  }
}

bool cf_sleep_holds(const drone_t *drone, mjData *data) {
  // first, because velocities of neighbors are side by side and their states are far apart
  if (!are_within(data->qvel + drone->dof_address, 6, ROUNDING)) {
    return false;
  }
  const cf_sleep_t *sleep = &cf_state_of(drone, data)->rest;
  return sleep->is_held && is_at(sleep->pose, data->qpos + drone->qpos_address, ROUNDING, ROUNDING);
}

void cf_sleep_force(const drone_t *drone, const mjModel *model, mjData *data, double out[6]) {
  const double *load   = cf_state_of(drone, data)->rest.load;
  const double *center = model->body_ipos + 3 * drone->body;
  double        lift[3];  // body frame
  double        r[9];
  cf_rotation_of(data->qpos + drone->qpos_address + 3, r);
  for (int i = 0; i < 3; i++) {
    out[i] = -model->body_mass[drone->body] * model->opt.gravity[i];
  }
  for (int i = 0; i < 3; i++) {
    lift[i] = r[i] * out[0] + r[3 + i] * out[1] + r[6 + i] * out[2];
  }
  out[3] = center[1] * lift[2] - center[2] * lift[1];
  out[4] = center[2] * lift[0] - center[0] * lift[2];
  out[5] = center[0] * lift[1] - center[1] * lift[0];
  for (int i = 0; i < 6; i++) {
    out[i] -= load[i];
  }
}
