#include "mujoco_plugin/sampling.h"

#include <string.h>
#include <time.h>

#include "mujoco_plugin/plugin.h"
#include "mujoco_plugin/swarm.h"
#include "mujoco_plugin/thread_pool.h"

#define GRAIN 32  // drones

typedef struct {
  const cf_sampled_part_t *part;
  uint8_t                 *row;
} copy_t;

static void copy_some(void *context, int begin, int end) {
  const copy_t            *copy  = context;
  const cf_sampled_part_t *part  = copy->part;
  char                    *first = (char *)part->first + begin * part->stride;
  cf_copy_logs(copy->row + begin * part->bytes, (cf_t *)(void *)first, end - begin, part->stride,
               part->bounds, part->stretches);
}

static void copy_part(const cf_sampled_part_t *part, int64_t row) {
  copy_t               copy     = {part, part->rows + row * part->count * part->bytes};
  const cf_provider_t *provider = cf_provider_of(part->first);
  if (provider != NULL && provider->refresh_logs != NULL) {
    copy_some(&copy, 0, part->count);
  } else {
    cf_parallel_for(part->count, GRAIN, copy_some, &copy);
  }
}

void cf_sample(const cf_sampler_t *sampler, int64_t row, int64_t requests) {
  sampler->times[row]    = *sampler->time;
  sampler->requests[row] = requests;
  for (int k = 0; k < sampler->part_count; k++) {
    copy_part(&sampler->parts[k], row);
  }
  memcpy(sampler->qpos_rows + row * sampler->nq, sampler->qpos,
         (size_t)sampler->nq * sizeof *sampler->qpos);
  double *motion = sampler->motion_rows + row * 6 * sampler->drones;
  for (int i = 0; i < sampler->drones; i++) {
    memcpy(motion + 6 * (ptrdiff_t)i, sampler->qvel + sampler->dofs[i], 6 * sizeof *motion);
  }
}

static double now(void) {
  struct timespec time;
  timespec_get(&time, TIME_UTC);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static bool has_news(const swarm_t *swarm, const cf_sampler_t *sampler) {
  bool has = swarm != NULL && swarm->collisions->count > 0;
  for (int k = 0; k < sampler->part_count && !has; k++) {
    const cf_sampled_part_t *part = &sampler->parts[k];
    for (int i = 0; i < part->count && !has; i++) {
      has = cf_is_out((const cf_t *)(const void *)((const char *)part->first + i * part->stride));
    }
  }
  return has;
}

cf_sampled_t cf_fly_and_sample(uintptr_t model, uintptr_t data, int steps, int count,
                               const cf_sampler_t *sampler, int64_t row, int64_t requests) {
  const swarm_t *swarm  = cf_swarm_of((const mjModel *)model, (const mjData *)data);
  cf_sampled_t   result = {.flown = steps};
  bool           goes   = true;
  while (goes && result.samples < count) {
    result.flown = cf_plugin_window(model, data, steps);
    goes         = result.flown == steps;
    if (goes) {
      const double begin = now();
      cf_sample(sampler, row + result.samples, requests);
      result.samples++;
      goes = !has_news(swarm, sampler);
      result.sampling += now() - begin;
    }
  }
  return result;
}
