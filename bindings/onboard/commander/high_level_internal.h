/* What the files of the high-level commander share. Internal to C. */
#ifndef CF_ONBOARD_COMMANDER_HIGH_LEVEL_INTERNAL_H
#define CF_ONBOARD_COMMANDER_HIGH_LEVEL_INTERNAL_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "onboard/commander/high_level_commander.h"

// The planner's clock: one division in double, rounded to float32
// (docs/reference/planner-commander.md#2).
static inline float cf_high_level_seconds(uint64_t now_us) {
  return (float)((double)now_us / 1e6);
}

static inline bool cf_high_level_is_positive(float value) {
  return isfinite(value) && value > 0.0f;
}

static inline cf_plan_start_t cf_high_level_plan_start(const cf_high_level_commander_t *commander) {
  return (cf_plan_start_t){.pos = commander->pos, .vel = commander->vel, .yaw = commander->yaw};
}

static inline cf_status_t cf_high_level_from_planner(int refused) {
  return refused != 0 ? CF_ERR_STATE : CF_OK;
}

#endif  // CF_ONBOARD_COMMANDER_HIGH_LEVEL_INTERNAL_H
