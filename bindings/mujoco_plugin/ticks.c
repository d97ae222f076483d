#include "mujoco_plugin/ticks.h"

#include <math.h>
#include <string.h>

#include "mujoco_plugin/broadcast.h"
#include "mujoco_plugin/downwash.h"
#include "mujoco_plugin/forces.h"
#include "mujoco_plugin/free_flight.h"
#include "mujoco_plugin/motion.h"
#include "mujoco_plugin/prefetch.h"
#include "mujoco_plugin/sleep.h"
#include "mujoco_plugin/thread_pool.h"
#include "mujoco_plugin/timing.h"
#include "mujoco_plugin/touch.h"

#define TICKS_PER_SECOND 1000.0
#define BLOCK 8  // drones that go through each part of a tick together, so that it can be timed

static const double *rates_of(const work_t *work) {
  return work->coordinates + 10;  // behind pose (7) and velocity (3)
}

static void copy_coordinates(const drone_t *drone, const mjData *data, double out[13]) {
  memcpy(out, data->qpos + drone->qpos_address, 7 * sizeof *out);
  memcpy(out + 7, data->qvel + drone->dof_address, 6 * sizeof *out);
}

// Drones that a thread takes at a time: a block, or less where that would leave a thread without
// work, or several, so that it knows which one comes next.
static int grain_of(const swarm_t *swarm) {
  if (cf_prefetch_pays(swarm)) {
    return 4 * BLOCK;
  }
  return swarm->count >= 4 * BLOCK ? BLOCK : BLOCK / 2;
}

// ------------------------------------------------------------------------------------- one part

static void sample(const swarm_t *swarm, int begin, int end) {
  const double elapsed = swarm->ticks / TICKS_PER_SECOND;
  for (int i = begin; i < end; i++) {
    cf_sleep_step(swarm, i, swarm->model, swarm->data, swarm->data->time, elapsed);
    cf_motion_sample(&swarm->drones[i], swarm->model, swarm->data, elapsed, &swarm->work[i].motion);
  }
}

// One tick of a block; `rest` is where the drones end that this thread ticks next.
static void tick_block(const swarm_t *swarm, int begin, int end, int rest) {
  cf_hardware_t  hardware[BLOCK];
  const uint64_t start = cf_timer_start();
  for (int i = begin; i < end; i++) {
    cf_t *cf = cf_state_of(&swarm->drones[i], swarm->data);
    cf_sense(cf, &swarm->work[i].motion, &hardware[i - begin]);
  }
  const uint64_t sensed        = cf_timer_add(TIME_VEHICLE, start);
  const bool     is_prefetched = cf_prefetch_pays(swarm);
  for (int i = begin; i < end; i++) {
    if (is_prefetched && i + BLOCK < rest) {
      cf_prefetch(cf_state_of(&swarm->drones[i + BLOCK], swarm->data));
    }
    cf_think(cf_state_of(&swarm->drones[i], swarm->data), &hardware[i - begin]);
  }
  const uint64_t thought = cf_timer_add(TIME_ONBOARD, sensed);
  for (int i = begin; i < end; i++) {
    cf_actuate(cf_state_of(&swarm->drones[i], swarm->data));
  }
  cf_timer_add(TIME_VEHICLE, thought);
}

static void tell_peers(const swarm_t *swarm, int begin, int end) {
  const uint64_t start = cf_timer_start();
  for (int i = begin; i < end; i++) {
    cf_broadcast_tell(swarm, i);
  }
  cf_timer_add(TIME_VEHICLE, start);
}

static void tell_surroundings(const swarm_t *swarm, int begin, int end) {
  const uint64_t start = cf_timer_start();
  for (int i = begin; i < end; i++) {
    cf_downwash_tell(swarm, i);
  }
  cf_timer_add(TIME_VEHICLE, start);
}

void cf_ticks_flock(const swarm_t *swarm, int begin, int end, bool is_first, int rest) {
  if (is_first && swarm->is_look) {
    tell_surroundings(swarm, begin, end);
  }
  if (is_first && swarm->is_broadcast) {
    tell_peers(swarm, begin, end);
  }
  tick_block(swarm, begin, end, rest);
}

static void tick_all(const swarm_t *swarm, int begin, int end, int rest) {
  for (int tick = 0; tick < swarm->ticks; tick++) {
    cf_ticks_flock(swarm, begin, end, tick == 0, rest);
  }
}

// The forces that the next step will ask for: the rotors are still in the cache.
static void push(const swarm_t *swarm, int begin, int end) {
  for (int i = begin; i < end; i++) {
    work_t *work = &swarm->work[i];
    cf_forces_of(swarm->model, &swarm->drones[i], cf_state_of(&swarm->drones[i], swarm->data),
                 &work->motion, rates_of(work), work->force);
  }
}

// What MuJoCo goes on with while the ticks run is kept.
static void keep_coordinates(const swarm_t *swarm, int begin, int end) {
  for (int i = begin; i < end; i++) {
    copy_coordinates(&swarm->drones[i], swarm->data, swarm->work[i].coordinates);
  }
}

// The parts of a step follow each other block by block: from a thousand drones on, what a block
// fetched is out of the cache again when all others have had their turn.
static void work_on(const swarm_t *swarm, int begin, int end, bool is_sampled, bool is_pushed) {
  for (int first = begin; first < end; first += BLOCK) {
    const int last = first + BLOCK < end ? first + BLOCK : end;
    if (is_sampled) {
      sample(swarm, first, last);
    }
    if (is_sampled && is_pushed) {
      keep_coordinates(swarm, first, last);
    }
    tick_all(swarm, first, last, end);
    if (is_pushed) {
      push(swarm, first, last);
    }
  }
}

static void tick_part(void *context, int begin, int end) {
  work_on(context, begin, end, false, false);
}

static void sample_and_tick_part(void *context, int begin, int end) {
  work_on(context, begin, end, true, false);
}

static void tick_and_push_part(void *context, int begin, int end) {
  work_on(context, begin, end, false, true);
}

// ------------------------------------------------------------------------------------ the swarm

void cf_ticks_finish(swarm_t *swarm) {
  if (swarm->is_pending) {
    cf_loop_finish();
    swarm->is_pending = false;
  }
}

void cf_ticks_overlap(swarm_t *swarm, bool is_overlapping) {
  cf_ticks_finish(swarm);
  swarm->is_overlapping = is_overlapping;
  swarm->has_forces     = false;
}

void cf_ticks_sample(swarm_t *swarm, const mjModel *model, mjData *data) {
  cf_ticks_finish(swarm);
  swarm->has_forces = false;
  swarm->model      = model;
  swarm->data       = data;
  for (int i = 0; i < swarm->count; i++) {
    cf_motion_of(&swarm->drones[i], data, &swarm->work[i].motion);
  }
}

// Whole ticks up to a time.
static double ticks_until(double time) {
  return floor(time * TICKS_PER_SECOND + 1e-3);
}

double cf_ticks_straight(const mjModel *model, double time) {
  const double exact = nearbyint(time / model->opt.timestep) * model->opt.timestep;
  return fabs(exact - time) < 1e-9 ? exact : time;
}

int cf_ticks_in_step(const mjModel *model, double time) {
  return (int)(ticks_until(time) - ticks_until(time - model->opt.timestep));
}

bool cf_ticks_look_is_due(const mjModel *model, double time) {
  const double now    = ticks_until(time);
  const double before = ticks_until(time - model->opt.timestep);
  return cf_broadcast_is_due(before, now) || cf_downwash_is_due(before, now);
}

static bool is_felt(const swarm_t *swarm) {
  return swarm->is_look && swarm->has_downwash;
}

bool cf_ticks_see_others(const swarm_t *swarm) {
  return swarm->is_broadcast || is_felt(swarm) || swarm->looking.is_needed;
}

void cf_ticks_look(swarm_t *swarm, mjData *data) {
  if (swarm->is_broadcast) {
    cf_broadcast_look(swarm);
  }
  if (is_felt(swarm)) {
    cf_downwash_look(swarm);
  }
  if (swarm->looking.is_needed) {
    cf_looking_begin(swarm, data);
  }
}

static void set_looks(swarm_t *swarm, const mjModel *model, double time) {
  const double now    = ticks_until(time);
  const double before = ticks_until(time - model->opt.timestep);
  swarm->is_broadcast = cf_broadcast_is_due(before, now) && cf_broadcast_has_listeners(swarm);
  swarm->is_look      = cf_downwash_is_due(before, now);
}

void cf_ticks_begin(swarm_t *swarm, const mjModel *model, mjData *data, double time) {
  swarm->model      = model;
  swarm->data       = data;
  swarm->ticks      = 1;
  swarm->has_forces = false;
  swarm->has_start  = false;
  cf_touch_forget(swarm);
  set_looks(swarm, model, time);
}

void cf_ticks_advance(const mjModel *model, mjData *data, swarm_t *swarm) {
  cf_ticks_finish(swarm);
  swarm->has_forces = false;
  swarm->model      = model;
  swarm->data       = data;
  data->time        = cf_ticks_straight(model, data->time);
  cf_free_flight_step(swarm, model, data);

  // ticks that fall into the step that just ended; MuJoCo has already advanced the time
  swarm->ticks = cf_ticks_in_step(model, data->time);
  if (data->ncon > 0) {
    cf_collisions_look(swarm, model, data);
  }
  if (swarm->ticks < 1) {
    return;
  }
  cf_touch_look(model, data, swarm, swarm->ticks / TICKS_PER_SECOND);
  set_looks(swarm, model, data->time);
  const bool sees_all = cf_ticks_see_others(swarm);
  if (!swarm->is_overlapping && !sees_all) {
    cf_parallel_for(swarm->count, grain_of(swarm), sample_and_tick_part, swarm);
    return;
  }

  // alone, a thread goes through everything at once
  if (!sees_all && cf_threads_get() == 1) {
    work_on(swarm, 0, swarm->count, true, true);
    swarm->has_forces = true;
    return;
  }

  sample(swarm, 0, swarm->count);
  cf_ticks_look(swarm, data);
  if (!swarm->is_overlapping) {
    cf_parallel_for(swarm->count, grain_of(swarm), tick_part, swarm);
    return;
  }

  // the threads see only what was sampled here: MuJoCo goes on with qpos and qvel
  keep_coordinates(swarm, 0, swarm->count);
  swarm->is_pending = cf_loop_start(swarm->count, grain_of(swarm), tick_and_push_part, swarm);
  if (!swarm->is_pending) {
    tick_and_push_part(swarm, 0, swarm->count);
  }
  swarm->has_forces = true;
}

static void add_forces(const mjModel *model, mjData *data, swarm_t *swarm, int i) {
  const drone_t *drone = &swarm->drones[i];
  work_t        *work  = &swarm->work[i];
  double         now[13];
  double         lift[6];
  copy_coordinates(drone, data, now);
  const double *force = work->force;
  if (cf_sleep_holds(drone, data)) {
    cf_sleep_force(drone, model, data, lift);
    force = lift;
  } else if (!swarm->has_forces || memcmp(now, work->coordinates, sizeof now) != 0) {
    cf_motion_of(drone, data, &work->motion);
    cf_forces_of(model, drone, cf_state_of(drone, data), &work->motion, now + 10, work->force);
  }
  memcpy(work->coordinates, now, sizeof now);  // free_flight.h starts from here
  for (int k = 0; k < 6; k++) {
    data->qfrc_passive[drone->dof_address + k] += force[k];
  }
}

typedef struct {
  const mjModel *model;
  mjData        *data;
  swarm_t       *swarm;
} compute_t;

static void compute_part(void *context, int begin, int end) {
  const compute_t *job   = context;
  const uint64_t   start = cf_timer_start();
  for (int i = begin; i < end; i++) {
    add_forces(job->model, job->data, job->swarm, i);
  }
  cf_timer_add(TIME_VEHICLE, start);
}

void cf_ticks_compute(const mjModel *model, mjData *data, swarm_t *swarm) {
  cf_ticks_finish(swarm);
  compute_t job = {.model = model, .data = data, .swarm = swarm};
  if (swarm->has_forces) {
    compute_part(&job, 0, swarm->count);  // only sums are left
  } else {
    // cheap, but each drone is still in the cache of the thread that ticked it
    cf_parallel_for(swarm->count, grain_of(swarm), compute_part, &job);
  }
  swarm->has_start = true;
}
