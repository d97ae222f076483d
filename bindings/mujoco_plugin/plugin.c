#define _DEFAULT_SOURCE  // clock_gettime, madvise
#include "mujoco_plugin/plugin.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#include "mujoco_plugin/attributes.h"
#include "mujoco_plugin/swarm.h"
#include "mujoco_plugin/thread_pool.h"
#include "mujoco_plugin/thrust_plugin.h"

#define PLUGIN_NAME "crazychoir.crazyflie"
#define TICKS_PER_SECOND 1000.0
#define DRONES_PER_PART 4   // a smaller part is not worth a thread
#define WAKE_VELOCITY 1e-9  // [m/s], enough for MuJoCo to wake a sleeping tree
#define WAKE_THRUST 1e-3f   // [N], a rotor that pushes harder wakes the drone
#define MAX_ATTRIBUTES 32

static cf_mujoco_api_t mj;
static int             plugin_slot = -1;

// ---------------------------------------------------------------------------- timing

enum { TIME_ONBOARD = 0, TIME_VEHICLE = 1, TIME_PARTS = 2 };

static atomic_bool            is_timed;
static _Atomic(uint_fast64_t) spent[TIME_PARTS];  // [ns], summed over threads

// Returns now [ns], or 0 while timing is off.
static uint64_t timer_start(void) {
  struct timespec now;
  if (!atomic_load_explicit(&is_timed, memory_order_relaxed)) {
    return 0;
  }
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

// Adds the time since `start` to a part and returns now.
static uint64_t timer_add(int part, uint64_t start) {
  const uint64_t now = timer_start();
  if (now != 0 && start != 0) {
    atomic_fetch_add_explicit(&spent[part], now - start, memory_order_relaxed);
  }
  return now;
}

void cf_plugin_timing(int enabled) {
  atomic_store(&is_timed, enabled != 0);
  for (int i = 0; i < TIME_PARTS; i++) {
    atomic_store(&spent[i], 0);
  }
}

void cf_plugin_timing_read(uint64_t nanoseconds[2]) {
  for (int i = 0; i < TIME_PARTS; i++) {
    nanoseconds[i] = atomic_load(&spent[i]);
  }
}

// ---------------------------------------------------------------------------- motion of a body

static cf_t *state_of(const drone_t *drone, mjData *data) {
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

static void motion_of(const drone_t *drone, const mjData *data, cf_motion_t *motion) {
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

// ---------------------------------------------------------------------------- advance: ticks

typedef struct {
  const mjModel *model;
  mjData        *data;
  const swarm_t *swarm;
  int            ticks;
} advance_t;

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

// A block of drones goes through each part of the tick together, so that the parts can be timed.
#define BLOCK 8

typedef struct {
  cf_t         *cf[BLOCK];
  cf_motion_t   motion[BLOCK];
  cf_hardware_t hardware[BLOCK];
  int           count;
} block_t;

static void tick_block(block_t *block) {
  const uint64_t start = timer_start();
  for (int i = 0; i < block->count; i++) {
    cf_sense(block->cf[i], &block->motion[i], &block->hardware[i]);
  }
  const uint64_t sensed = timer_add(TIME_VEHICLE, start);
  for (int i = 0; i < block->count; i++) {
    cf_think(block->cf[i], &block->hardware[i]);
  }
  const uint64_t thought = timer_add(TIME_ONBOARD, sensed);
  for (int i = 0; i < block->count; i++) {
    cf_actuate(block->cf[i]);
  }
  timer_add(TIME_VEHICLE, thought);
}

static void advance_block(const advance_t *job, int begin, int end) {
  const double elapsed = job->ticks / TICKS_PER_SECOND;
  block_t      block   = {.count = end - begin};
  for (int i = 0; i < block.count; i++) {
    const drone_t *drone = &job->swarm->drones[begin + i];
    block.cf[i]          = state_of(drone, job->data);
    motion_of(drone, job->data, &block.motion[i]);
    specific_force_of(drone, job->model, job->data, block.cf[i], elapsed, &block.motion[i]);
  }

  for (int tick = 0; tick < job->ticks; tick++) {
    tick_block(&block);
  }

  for (int i = 0; i < block.count; i++) {
    const drone_t *drone = &job->swarm->drones[begin + i];
    cf_t          *cf    = block.cf[i];
    if (!is_finite_state(drone, job->data)) {
      park(drone, job->model, job->data);
    }
    memcpy(cf->last_velocity, job->data->qvel + drone->dof_address, sizeof cf->last_velocity);
    cf->has_last_velocity = true;
    wake_if_thrusting(drone, job->data, cf);
  }
}

static void advance_part(void *context, int begin, int end) {
  for (int first = begin; first < end; first += BLOCK) {
    advance_block(context, first, first + BLOCK < end ? first + BLOCK : end);
  }
}

// Ticks that fall into the step that just ended. MuJoCo has already advanced the time.
static int ticks_due(const mjModel *model, const mjData *data) {
  const double now    = floor(data->time * TICKS_PER_SECOND + 1e-3);
  const double before = floor((data->time - model->opt.timestep) * TICKS_PER_SECOND + 1e-3);
  return (int)(now - before);
}

static void advance(const mjModel *model, mjData *data, int instance) {
  const drone_t *drone = (const drone_t *)data->plugin_data[instance];
  if (instance != drone->swarm->last_instance) {
    return;  // the last instance works for all, so that they can share threads
  }
  advance_t job = {
      .model = model, .data = data, .swarm = drone->swarm, .ticks = ticks_due(model, data)};
  if (job.ticks < 1) {
    return;
  }
  cf_parallel_for(drone->swarm->count, DRONES_PER_PART, advance_part, &job);
}

// ---------------------------------------------------------------------------- compute: forces

static void multiply3(const double m[9], const double v[3], double out[3]) {
  for (int i = 0; i < 3; i++) {
    out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
  }
}

static void gyroscopic_torque(const drone_t *drone, const double rates[3], double out[3]) {
  double momentum[3];
  multiply3(drone->inertia, rates, momentum);
  out[0] = rates[1] * momentum[2] - rates[2] * momentum[1];
  out[1] = rates[2] * momentum[0] - rates[0] * momentum[2];
  out[2] = rates[0] * momentum[1] - rates[1] * momentum[0];
}

// MuJoCo's Euler step takes the gyroscopic torque g(w) = w x Jw at the start of the step, which
// makes a tumbling body gain energy. Taking it at the middle, w_h = w + dt/2 J^-1 (torque - g(w)),
// repairs that: add g(w) - g(w_h).
static void add_midpoint_gyroscopics(const drone_t *drone, const double rates[3], double timestep,
                                     double torque[3]) {
  double now[3], acceleration[3], middle[3], later[3], net[3];
  gyroscopic_torque(drone, rates, now);
  for (int i = 0; i < 3; i++) {
    net[i] = torque[i] - now[i];
  }
  multiply3(drone->inverse_inertia, net, acceleration);
  for (int i = 0; i < 3; i++) {
    middle[i] = rates[i] + 0.5 * timestep * acceleration[i];
  }
  gyroscopic_torque(drone, middle, later);
  for (int i = 0; i < 3; i++) {
    torque[i] += now[i] - later[i];
  }
}

static void compute_one(const mjModel *model, mjData *data, const drone_t *drone) {
  cf_motion_t motion = {0};
  float       force[3];
  float       body_torque[3];
  motion_of(drone, data, &motion);
  cf_wrench(state_of(drone, data), &motion, force, body_torque);

  double torque[3] = {body_torque[0], body_torque[1], body_torque[2]};
  if (model->opt.integrator == mjINT_EULER) {
    add_midpoint_gyroscopics(drone, data->qvel + drone->dof_address + 3, model->opt.timestep,
                             torque);
  }
  double *out = data->qfrc_passive + drone->dof_address;
  for (int i = 0; i < 3; i++) {
    out[i] += (double)force[i];
    out[3 + i] += torque[i];
  }
}

typedef struct {
  const mjModel *model;
  mjData        *data;
  const swarm_t *swarm;
} compute_t;

static void compute_part(void *context, int begin, int end) {
  const compute_t *job   = context;
  const uint64_t   start = timer_start();
  for (int i = begin; i < end; i++) {
    compute_one(job->model, job->data, &job->swarm->drones[i]);
  }
  timer_add(TIME_VEHICLE, start);
}

static void compute(const mjModel *model, mjData *data, int instance, int capability) {
  (void)capability;
  const drone_t *drone = (const drone_t *)data->plugin_data[instance];
  if (instance != drone->swarm->last_instance) {
    return;
  }
  // cheap, but each drone is still in the cache of the thread that ticked it
  compute_t job = {.model = model, .data = data, .swarm = drone->swarm};
  cf_parallel_for(drone->swarm->count, DRONES_PER_PART, compute_part, &job);
}

// ---------------------------------------------------------------------------- life of an instance

static int state_size(const mjModel *model, int instance) {
  (void)model;
  (void)instance;
  return cf_state_bytes() / (int)sizeof(mjtNum);
}

static swarm_t *swarm_of(const mjModel *model, const mjData *data) {
  for (int i = 0; i < model->nplugin; i++) {
    if (model->plugin[i] == plugin_slot && data->plugin_data[i] != 0) {
      return ((drone_t *)data->plugin_data[i])->swarm;
    }
  }
  return NULL;
}

// A thousand drones are megabytes that every step walks through: large pages spare most of the
// address translation. Only advice, without effect where the system has none.
static void ask_for_large_pages(mjData *data) {
#ifdef MADV_HUGEPAGE
  const uintptr_t page  = (uintptr_t)1 << 21;
  const uintptr_t begin = ((uintptr_t)data->buffer + page - 1) & ~(page - 1);
  const uintptr_t end   = ((uintptr_t)data->buffer + (uintptr_t)data->nbuffer) & ~(page - 1);
  if (end > begin) {
    madvise((void *)begin, end - begin, MADV_HUGEPAGE);
  }
#endif
}

static int init(const mjModel *model, mjData *data, int instance) {
  bool is_first = true;
  for (int i = 0; i < instance; i++) {
    is_first = is_first && model->plugin[i] != plugin_slot;
  }
  if (is_first) {
    // nothing of ours is in plugin_data yet, and it may hold anything
    for (int i = 0; i < model->nplugin; i++) {
      if (model->plugin[i] == plugin_slot) {
        data->plugin_data[i] = 0;
      }
    }
    cf_swarm_check_timestep(&mj, model->opt.timestep);
    ask_for_large_pages(data);
  }

  swarm_t *swarm = is_first ? cf_swarm_new(&mj, model, plugin_slot) : swarm_of(model, data);
  if (swarm == NULL) {
    return -1;
  }
  swarm->references++;
  data->plugin_data[instance] = (uintptr_t)cf_swarm_find(swarm, instance);
  return 0;
}

static void destroy(mjData *data, int instance) {
  drone_t *drone = (drone_t *)data->plugin_data[instance];
  if (drone != NULL) {
    data->plugin_data[instance] = 0;
    if (--drone->swarm->references == 0) {
      cf_swarm_free(drone->swarm);
    }
  }
}

// plugin_data depends on the model only, and the copy has been initialised from the same model.
static void copy(mjData *destination, const mjModel *model, const mjData *source, int instance) {
  (void)destination;
  (void)model;
  (void)source;
  (void)instance;
}

static void reset(const mjModel *model, mjtNum *plugin_state, void *plugin_data, int instance) {
  (void)model;
  (void)instance;
  const drone_t *drone = plugin_data;
  cf_init((cf_t *)plugin_state, &drone->config);
}

int cf_plugin_mujoco_version(void) {
  return mjVERSION_HEADER;
}

int cf_plugin_register(const char *libmujoco_path) {
  static const char *attributes[MAX_ATTRIBUTES];

  if (cf_mujoco_api_find(&mj, libmujoco_path) != 0) {
    return -1;
  }
  // patch releases keep the layout of mjModel and mjData
  if (mj.version() / 1000 != mjVERSION_HEADER / 1000) {
    return -2;
  }
  for (int i = 0; i < cf_attribute_count(); i++) {
    attributes[i] = cf_attribute_name(i);
  }

  mjpPlugin plugin;
  mj.default_plugin(&plugin);
  plugin.name            = PLUGIN_NAME;
  plugin.nattribute      = cf_attribute_count();
  plugin.attributes      = attributes;
  plugin.capabilityflags = mjPLUGIN_PASSIVE;
  plugin.nstate          = state_size;
  plugin.init            = init;
  plugin.destroy         = destroy;
  plugin.copy            = copy;
  plugin.reset           = reset;
  plugin.compute         = compute;
  plugin.advance         = advance;
  plugin_slot            = mj.register_plugin(&plugin);
  return plugin_slot < 0 || cf_thrust_plugin_register(&mj) < 0 ? -1 : 0;
}
