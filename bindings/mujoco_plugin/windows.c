#include "mujoco_plugin/windows.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_plugin/downwash.h"
#include "mujoco_plugin/forces.h"
#include "mujoco_plugin/free_flight.h"
#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/prefetch.h"
#include "mujoco_plugin/rooms.h"
#include "mujoco_plugin/sleep.h"
#include "mujoco_plugin/thread_pool.h"
#include "mujoco_plugin/ticks.h"

#define STEP 0.001     // [s]
#define FLOCK 8        // drones that go through a window together
#define FIRST_PAUSE 8  // steps until a window is tried again
#define LONGEST_PAUSE 64
#define MOST_GRAVITY 30.0  // [m/s^2], each way

struct cf_windows_s {
  cf_rooms_t rooms;
  mjtNum    *before;   // qpos, qvel, qacc, qacc_warmstart, plugin_state; null while none is held
  double (*poses)[7];  // at the start of the last step, by drone
  int pause;

  const mjModel *model;
  mjData        *data;
  int            ticks;
  int            posed_tick;  // whose poses are kept; -1: of none
  double         times[CF_MOST_WINDOW_TICKS];
  bool          *has_held;  // by flock: one of it is held, so that it may break the window
  bool           is_saved;  // a flock has
  bool           is_held_turn;
  bool           is_begun;  // the first step has been made, and all have looked around
  atomic_bool    is_broken;
};

// ---------------------------------------------------------------------------------- is it possible

static bool has_only_free_drones(const swarm_t *swarm, const mjModel *model) {
  bool only = model->nplugin == swarm->count && model->nv == 6 * swarm->count;
  for (int i = 0; i < swarm->count; i++) {
    const drone_t *drone = &swarm->drones[i];
    only = only && drone->is_free && drone->can_sleep && drone->reach < CF_ROOMS_REACH;
  }
  return only;
}

static bool has_no_machinery(const mjModel *model) {
  return model->nmocap == 0 && model->neq == 0 && model->ntendon == 0 && model->nu == 0 &&
         model->na == 0 && model->nsensor == 0 && model->nflex == 0 && model->nhistory == 0;
}

static bool has_no_margins(const mjModel *model) {
  bool none = true;
  for (int geom = 0; geom < model->ngeom; geom++) {
    none = none && model->geom_margin[geom] == 0;
  }
  return none && model->npair == 0;
}

void cf_windows_new(swarm_t *swarm, const mjModel *model) {
  if (!has_only_free_drones(swarm, model) || !has_no_machinery(model) || !has_no_margins(model) ||
      !cf_scenery_is_flat_floor(swarm->scenery)) {
    return;
  }
  struct cf_windows_s *windows = calloc(1, sizeof *windows);
  if (windows == NULL) {
    return;  // single steps do as well
  }
  swarm->windows    = windows;
  windows->pause    = FIRST_PAUSE;
  windows->has_held = calloc((size_t)swarm->count, sizeof *windows->has_held);
  windows->poses    = calloc((size_t)swarm->count, sizeof *windows->poses);
  if (windows->has_held == NULL || windows->poses == NULL ||
      !cf_rooms_new(&windows->rooms, swarm)) {
    cf_windows_free(swarm);
  }
}

void cf_windows_free(swarm_t *swarm) {
  if (swarm->windows != NULL) {
    cf_rooms_free(&swarm->windows->rooms);
    free(swarm->windows->has_held);
    free(swarm->windows->before);
    free(swarm->windows->poses);
    free(swarm->windows);
    swarm->windows = NULL;
  }
}

static bool are_zero(const mjtNum *numbers, mjtSize count) {
  mjtNum sum = 0;
  for (mjtSize i = 0; i < count; i++) {
    sum += fabs(numbers[i]);
  }
  return sum == 0;
}

static bool is_plain(const mjOption *option) {
  const int without_forces = mjDSBL_SPRING | mjDSBL_DAMPER;
  bool      plain = option->integrator == mjINT_EULER && option->enableflags == 0 &&
                    fabs(option->timestep - STEP) < 1e-9 && option->density == 0 &&
                    option->viscosity == 0 && (option->disableflags & mjDSBL_AUTORESET) != 0 &&
                    (option->disableflags & without_forces) != without_forces;
  for (int i = 0; i < 3; i++) {
    plain = plain && fabs(option->gravity[i]) < MOST_GRAVITY;
  }
  return plain;
}

static bool is_allowed_now(const swarm_t *swarm, const mjModel *model, const mjData *data) {
  return is_plain(&model->opt) && !swarm->looking.is_needed && *swarm->mj->passive == NULL &&
         *swarm->mj->control == NULL && are_zero(data->qfrc_applied, model->nv) &&
         are_zero(data->xfrc_applied, 6 * model->nbody);
}

// ------------------------------------------------------------------------------------ take it back

static mjtNum *saved_state(const struct cf_windows_s *windows) {
  return windows->before + windows->model->nq + 3 * windows->model->nv;
}

static size_t state_bytes(const swarm_t *swarm, int i) {
  return (size_t)swarm->windows->model->plugin_statenum[swarm->drones[i].instance] * sizeof(mjtNum);
}

// What one step changes in the memory of a drone before it ticks; all, in a flock that may break
// the window while it ticks.
static void copy_memory(const swarm_t *swarm, int i, bool is_back) {
  const struct cf_windows_s *windows = swarm->windows;
  const int                  address = swarm->drones[i].state_address;
  const bool                 is_all  = windows->has_held[i / FLOCK];
  const size_t               begin   = is_all ? 0 : offsetof(cf_t, last_velocity);
  const size_t               end  = is_all ? state_bytes(swarm, i) : offsetof(cf_t, configuration);
  char                      *kept = (char *)(saved_state(windows) + address) + begin;
  char                      *now  = (char *)(windows->data->plugin_state + address) + begin;
  memcpy(is_back ? now : kept, is_back ? kept : now, end - begin);
}

// Copies the motion of all drones out or back.
static void copy_motion(const struct cf_windows_s *windows, bool is_back) {
  mjData       *data     = windows->data;
  const mjtSize nv       = windows->model->nv;
  mjtNum       *parts[]  = {data->qpos, data->qvel, data->qacc, data->qacc_warmstart};
  const mjtSize counts[] = {windows->model->nq, nv, nv, nv};
  mjtNum       *kept     = windows->before;
  for (int i = 0; i < 4; i++) {
    const size_t bytes = (size_t)counts[i] * sizeof *kept;
    memcpy(is_back ? parts[i] : kept, is_back ? kept : parts[i], bytes);
    kept += counts[i];
  }
}

static void take_back(const swarm_t *swarm) {
  const struct cf_windows_s *windows = swarm->windows;
  copy_motion(windows, true);
  for (int i = 0; i < swarm->count; i++) {
    // flocks that had their turn: all, if they have looked around, and else those with held ones
    if (windows->is_begun || windows->has_held[i / FLOCK]) {
      copy_memory(swarm, i, true);
    }
  }
}

// -------------------------------------------------------------------------------------- the flight

static void force_on(const swarm_t *swarm, int i, int tick, const double start[13],
                     double force[6]) {
  const drone_t *drone  = &swarm->drones[i];
  const mjModel *model  = swarm->windows->model;
  mjData        *data   = swarm->windows->data;
  cf_motion_t   *motion = &swarm->work[i].motion;
  // a drone that was not asleep when the window was planned is not put to sleep within it
  if (swarm->windows->rooms.of[i].is_held && cf_sleep_holds(drone, data)) {
    cf_sleep_force(drone, model, data, force);
    return;
  }
  if (tick == 0) {
    cf_motion_of(drone, data, motion);
  }
  cf_forces_of(model, drone, cf_state_of(drone, data), motion, start + 10, force);
}

// One step of a drone, and its motion after it. Returns false when a held one is not held any more:
// it touches the floor, and others may touch it.
static bool step_drone(const swarm_t *swarm, int i, int tick) {
  const struct cf_windows_s *windows = swarm->windows;
  mjData                    *data    = windows->data;
  drone_t                   *drone   = &swarm->drones[i];
  const bool                 is_held = windows->rooms.of[i].is_held;
  double                     start[13];
  double                     force[6];
  memcpy(start, data->qpos + drone->qpos_address, 7 * sizeof *start);
  memcpy(start + 7, data->qvel + drone->dof_address, 6 * sizeof *start);
  if (tick == windows->posed_tick) {
    memcpy(windows->poses[i], start, sizeof windows->poses[i]);
  }
  force_on(swarm, i, tick, start, force);
  cf_free_flight_move(drone, windows->model, data, start, force);
  if (is_held && cf_sleep_has_left(drone, data, STEP)) {
    return false;
  }
  cf_sleep_step(swarm, i, windows->model, data, windows->times[tick], STEP);
  cf_motion_sample(drone, windows->model, data, STEP, &swarm->work[i].motion);
  return cf_state_of(drone, data)->rest.is_held == is_held;
}

// One tick of a flock up to the motions that its drones sense.
static void step_flock(const swarm_t *swarm, int begin, int end, int tick) {
  bool is_whole = true;
  for (int i = begin; i < end; i++) {
    if (tick == 0 && swarm->windows->is_saved) {
      copy_memory(swarm, i, false);
    }
    is_whole = step_drone(swarm, i, tick) && is_whole;
  }
  if (!is_whole) {
    atomic_store_explicit(&swarm->windows->is_broken, true, memory_order_relaxed);
  }
}

static void fly_flock(const swarm_t *swarm, int begin, int end, int rest) {
  const struct cf_windows_s *windows  = swarm->windows;
  bool                       is_whole = true;
  for (int tick = 0; tick < windows->ticks && is_whole; tick++) {
    if (tick > 0 || !windows->is_begun) {
      step_flock(swarm, begin, end, tick);
    }
    is_whole = !atomic_load_explicit(&windows->is_broken, memory_order_relaxed);
    if (is_whole) {
      // the next flock is fetched while this one ticks for the last time
      cf_ticks_flock(swarm, begin, end, tick == 0, tick + 1 < windows->ticks ? end : rest);
    }
  }
}

static int end_of_flock(int first, int end) {
  return first + FLOCK < end ? first + FLOCK : end;
}

static void begin_part(void *context, int begin, int end) {
  for (int first = begin; first < end; first += FLOCK) {
    step_flock(context, first, end_of_flock(first, end), 0);
  }
}

static void fly_part(void *context, int begin, int end) {
  const swarm_t             *swarm   = context;
  const struct cf_windows_s *windows = swarm->windows;
  for (int first = begin; first < end; first += FLOCK) {
    if (windows->has_held[first / FLOCK] == windows->is_held_turn) {
      fly_flock(swarm, first, end_of_flock(first, end), end);
    }
  }
}

// Room for the state of the swarm is kept only while it is used. Returns false without memory.
static bool make_room_to_save(struct cf_windows_s *windows, const mjModel *model) {
  if (windows->before == NULL) {
    const size_t numbers = (size_t)(model->nq + 3 * model->nv) + (size_t)model->npluginstate;
    windows->before      = malloc(numbers * sizeof *windows->before);
  }
  return windows->before != NULL;
}

static void give_back_room(struct cf_windows_s *windows) {
  free(windows->before);
  windows->before = NULL;
}

// What the ticks start with: those of the first one may look around. Returns false without memory.
static bool prepare(swarm_t *swarm, const mjModel *model, mjData *data, int ticks) {
  struct cf_windows_s *windows = swarm->windows;
  windows->model               = model;
  windows->data                = data;
  windows->ticks               = ticks;
  windows->is_begun            = false;
  windows->is_saved            = false;
  atomic_store(&windows->is_broken, false);
  for (int i = 0; i < swarm->count; i++) {
    const bool is_held = windows->rooms.of[i].is_held;
    bool      *flock   = &windows->has_held[i / FLOCK];
    *flock             = (i % FLOCK != 0 && *flock) || is_held;
    windows->is_saved  = windows->is_saved || is_held;
  }
  if (windows->is_saved && !make_room_to_save(windows, model)) {
    return false;
  }
  if (windows->is_saved) {
    copy_motion(windows, false);
  }
  cf_ticks_begin(swarm, model, data, windows->times[0]);
  return true;
}

// Lets flocks with held drones go first: one that wakes breaks the window, and then the others have
// not ticked yet. Returns whether the window held.
static bool fly(swarm_t *swarm) {
  struct cf_windows_s *windows = swarm->windows;
  const int            grain   = cf_prefetch_pays(swarm) ? 4 * FLOCK : FLOCK;
  if (cf_ticks_see_others(swarm)) {
    windows->is_begun = true;
    cf_parallel_for(swarm->count, grain, begin_part, swarm);
    cf_ticks_look(swarm, windows->data);
  }
  if (windows->is_saved) {
    windows->is_held_turn = true;
    cf_parallel_for(swarm->count, grain, fly_part, swarm);
    if (atomic_load(&windows->is_broken)) {
      return false;
    }
  }
  windows->is_held_turn = false;
  cf_parallel_for(swarm->count, grain, fly_part, swarm);
  return true;
}

// Plans the steps of a window: it ends before the next look around. Returns how many.
static int plan(swarm_t *swarm, const mjModel *model, const mjData *data, int ticks) {
  const int most  = ticks < CF_MOST_WINDOW_TICKS ? ticks : CF_MOST_WINDOW_TICKS;
  double    time  = data->time;
  int       count = 0;
  while (count < most) {
    const double next = cf_ticks_straight(model, time + model->opt.timestep);
    if (cf_ticks_in_step(model, next) != 1 || (count > 0 && cf_ticks_look_is_due(model, next))) {
      break;
    }
    swarm->windows->times[count++] = time = next;
  }
  return count;
}

// Bodies, geoms, sites, cameras and lights are where the last step began, as after one of MuJoCo's.
static void pose_bodies(const swarm_t *swarm, const mjModel *model, mjData *data) {
  for (int turn = 0; turn < 2; turn++) {
    for (int i = 0; i < swarm->count; i++) {
      double  now[7];
      double *pose = data->qpos + swarm->drones[i].qpos_address;
      memcpy(now, pose, sizeof now);
      memcpy(pose, swarm->windows->poses[i], sizeof now);
      memcpy(swarm->windows->poses[i], now, sizeof now);
    }
    if (turn == 0) {
      swarm->mj->kinematics(model, data);
      swarm->mj->com_pos(model, data);
      swarm->mj->camlight(model, data);
    }
  }
}

static int pause_longer(struct cf_windows_s *windows) {
  const int pause = windows->pause;
  windows->pause  = pause < LONGEST_PAUSE ? 2 * pause : pause;
  return -pause;
}

int cf_windows_run(swarm_t *swarm, const mjModel *model, mjData *data, int ticks) {
  struct cf_windows_s *windows = swarm->windows;
  if (windows == NULL || !is_allowed_now(swarm, model, data)) {
    return -LONGEST_PAUSE;
  }
  cf_ticks_finish(swarm);
  int done = 0;
  while (done < ticks) {
    const int planned   = plan(swarm, model, data, ticks - done);
    windows->posed_tick = done + planned == ticks ? planned - 1 : -1;
    if (planned < 1 || !cf_rooms_suffice(&windows->rooms, swarm, model, data, planned) ||
        !prepare(swarm, model, data, planned)) {
      break;
    }
    if (!fly(swarm)) {
      take_back(swarm);
      break;
    }
    data->time = windows->times[planned - 1];
    data->ncon = 0;
    done += planned;
  }
  if (done == 0) {
    return pause_longer(windows);
  }
  if (!windows->is_saved) {
    give_back_room(windows);
  }
  windows->pause = FIRST_PAUSE;
  if (done == ticks) {
    pose_bodies(swarm, model, data);
  }
  return done;
}
