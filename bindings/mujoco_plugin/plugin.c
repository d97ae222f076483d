#define _DEFAULT_SOURCE  // madvise
#include "mujoco_plugin/plugin.h"

#include <stdint.h>
#include <string.h>
#include <sys/mman.h>

#include "mujoco_plugin/attributes.h"
#include "mujoco_plugin/contact_filter.h"
#include "mujoco_plugin/free_flight.h"
#include "mujoco_plugin/swarm.h"
#include "mujoco_plugin/thrust_plugin.h"
#include "mujoco_plugin/ticks.h"
#include "mujoco_plugin/windows.h"

#define PLUGIN_NAME "crazychoir.crazyflie"
#define MAX_ATTRIBUTES 128

static cf_mujoco_api_t mj;

// The last instance works for all, so that they can share threads.
static swarm_t *swarm_if_last(const mjData *data, int instance) {
  const drone_t *drone = (const drone_t *)data->plugin_data[instance];
  return instance == drone->swarm->last_instance ? drone->swarm : NULL;
}

static void advance(const mjModel *model, mjData *data, int instance) {
  swarm_t *swarm = swarm_if_last(data, instance);
  if (swarm != NULL) {
    cf_ticks_advance(model, data, swarm);
  }
}

static void compute(const mjModel *model, mjData *data, int instance, int capability) {
  (void)capability;
  swarm_t *swarm = swarm_if_last(data, instance);
  if (swarm != NULL) {
    cf_ticks_compute(model, data, swarm);
  }
}

// ---------------------------------------------------------------------------- life of an instance

static int state_size(const mjModel *model, int instance) {
  return cf_state_bytes(cf_swarm_provider(&mj, model, instance)) / (int)sizeof(mjtNum);
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

void cf_plugin_overlap(uintptr_t model, uintptr_t data, int is_overlapping) {
  swarm_t *swarm = cf_swarm_of((const mjModel *)model, (const mjData *)data);
  if (swarm != NULL) {
    cf_ticks_overlap(swarm, is_overlapping != 0);
  }
}

const double *cf_plugin_clock(uintptr_t data) {
  return &((const mjData *)data)->time;
}

int cf_plugin_window(uintptr_t model, uintptr_t data, int ticks) {
  swarm_t *swarm = cf_swarm_of((const mjModel *)model, (const mjData *)data);
  return swarm != NULL ? cf_windows_run(swarm, (const mjModel *)model, (mjData *)data, ticks)
                       : -ticks;
}

int cf_plugin_take_collisions(uintptr_t model, uintptr_t data, cf_collision_t *collisions,
                              int capacity, uint32_t *lost) {
  swarm_t *swarm = cf_swarm_of((const mjModel *)model, (const mjData *)data);
  *lost          = 0;
  if (swarm == NULL || swarm->collisions->count == 0) {
    return 0;
  }
  cf_collisions_t *told  = swarm->collisions;
  const int        count = told->count < capacity ? told->count : capacity;
  memcpy(collisions, told->list, (size_t)count * sizeof *collisions);
  told->count -= count;
  memmove(told->list, told->list + count, (size_t)told->count * sizeof *told->list);
  *lost      = told->lost;
  told->lost = 0;
  return count;
}

float cf_plugin_look(uintptr_t model, uintptr_t data, int self, const float point[3],
                     const float direction[3], float cone, float reach) {
  swarm_t *swarm = cf_swarm_of((const mjModel *)model, (const mjData *)data);
  if (swarm == NULL) {
    return -1.0f;
  }
  cf_ticks_sample(swarm, (const mjModel *)model, (mjData *)data);
  cf_looking_begin(swarm, (const mjData *)data);
  return cf_looking_distance(swarm, self, point, direction, cone, reach);
}

static int init(const mjModel *model, mjData *data, int instance) {
  bool is_first = true;
  for (int i = 0; i < instance; i++) {
    is_first = is_first && !cf_swarm_has(model, i);
  }
  if (is_first) {
    // nothing of ours is in plugin_data yet, and it may hold anything
    for (int i = 0; i < model->nplugin; i++) {
      if (cf_swarm_has(model, i)) {
        data->plugin_data[i] = 0;
      }
    }
    cf_swarm_check_timestep(&mj, model->opt.timestep);
    ask_for_large_pages(data);
    cf_contact_filter_install(&mj);
  }

  swarm_t *swarm = is_first ? cf_swarm_new(&mj, model) : cf_swarm_of(model, data);
  if (swarm == NULL) {
    return -1;
  }
  if (is_first) {
    cf_free_flight_new(swarm, model);
    cf_windows_new(swarm, model);
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
      cf_windows_free(drone->swarm);
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
  cf_init((cf_t *)plugin_state, drone->config);
}

const char *cf_plugin_attribute(uintptr_t model, int instance, const char *name) {
  const mjModel *m = (const mjModel *)model;
  if (instance < 0 || instance >= m->nplugin || !cf_swarm_has(m, instance)) {
    return NULL;
  }
  const char *text = mj.get_config(m, instance, name);
  return text != NULL ? text : "";
}

void cf_plugin_stop_clock(void) {
  *mj.clock = NULL;
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
  const int slot         = mj.register_plugin(&plugin);
  cf_swarm_set_slot(slot);
  return slot < 0 || cf_thrust_plugin_register(&mj) < 0 ? -1 : 0;
}
