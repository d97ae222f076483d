#include "mujoco_plugin/sampling.h"

#include <string.h>

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
