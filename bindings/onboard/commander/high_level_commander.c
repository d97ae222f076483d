#include "onboard/commander/high_level_commander.h"

#include <math.h>
#include <stddef.h>

#include "api/math3d.h"
#include "onboard/commander/high_level_internal.h"
#include "variable_row.h"

#define DEFAULT_VELOCITY 0.5f  // [m/s], of take-off and landing

void cf_high_level_commander_init(cf_high_level_commander_t *commander) {
  *commander = (cf_high_level_commander_t){.vtoff = DEFAULT_VELOCITY, .vland = DEFAULT_VELOCITY};
}

// The entry of a provider that plans a take-off or a landing.
typedef int (*plan_vertical_t)(void *state, const cf_plan_start_t *from, float height, float yaw,
                               float duration, float t);

// `duration` may be 0 here: a vehicle that is at the height already.
static cf_status_t plan_vertical(const cf_high_level_commander_t *commander, plan_vertical_t plan,
                                 void *provider_state, float height, float duration, float yaw,
                                 bool use_current_yaw, uint64_t now_us) {
  const float goal_yaw = use_current_yaw ? commander->yaw : yaw;
  if (!isfinite(height) || !isfinite(duration) || (!use_current_yaw && !isfinite(yaw))) {
    return CF_ERR_VALUE;
  }
  if (commander->is_blocked) {
    return CF_ERR_BLOCKED;
  }
  const cf_plan_start_t from = cf_high_level_plan_start(commander);
  return cf_high_level_from_planner(
      plan(provider_state, &from, height, goal_yaw, duration, cf_high_level_seconds(now_us)));
}

cf_status_t cf_high_level_commander_takeoff(cf_high_level_commander_t *commander,
                                            const cf_provider_t *provider, void *provider_state,
                                            float height, float duration, float yaw,
                                            bool use_current_yaw, uint64_t now_us) {
  if (!cf_high_level_is_positive(duration)) {
    return CF_ERR_VALUE;
  }
  return plan_vertical(commander, provider->plan_takeoff, provider_state, height, duration, yaw,
                       use_current_yaw, now_us);
}

cf_status_t cf_high_level_commander_land(cf_high_level_commander_t *commander,
                                         const cf_provider_t *provider, void *provider_state,
                                         float height, float duration, float yaw,
                                         bool use_current_yaw, uint64_t now_us) {
  if (!cf_high_level_is_positive(duration)) {
    return CF_ERR_VALUE;
  }
  return plan_vertical(commander, provider->plan_land, provider_state, height, duration, yaw,
                       use_current_yaw, now_us);
}

// Time [s] to a height [m] at a speed [m/s], NaN for a speed that leads nowhere.
static float duration_to(const cf_high_level_commander_t *commander, float height, float velocity,
                         float default_velocity) {
  const float speed = velocity > 0.0f ? velocity : default_velocity;
  if (!isfinite(velocity) || !cf_high_level_is_positive(speed)) {
    return NAN;
  }
  return fabsf(height - commander->pos.z) / speed;
}

cf_status_t cf_high_level_commander_takeoff_with_velocity(cf_high_level_commander_t *commander,
                                                          const cf_provider_t       *provider,
                                                          void *provider_state, float height,
                                                          bool height_is_relative, float velocity,
                                                          float yaw, bool use_current_yaw,
                                                          uint64_t now_us) {
  const float goal     = height_is_relative ? height + commander->pos.z : height;
  const float duration = duration_to(commander, goal, velocity, commander->vtoff);
  return plan_vertical(commander, provider->plan_takeoff, provider_state, goal, duration, yaw,
                       use_current_yaw, now_us);
}

cf_status_t cf_high_level_commander_land_with_velocity(cf_high_level_commander_t *commander,
                                                       const cf_provider_t       *provider,
                                                       void *provider_state, float height,
                                                       bool height_is_relative, float velocity,
                                                       float yaw, bool use_current_yaw,
                                                       uint64_t now_us) {
  const float goal     = height_is_relative ? commander->pos.z - height : height;
  const float duration = duration_to(commander, goal, velocity, commander->vland);
  return plan_vertical(commander, provider->plan_land, provider_state, goal, duration, yaw,
                       use_current_yaw, now_us);
}

cf_status_t cf_high_level_commander_stop(cf_high_level_commander_t *commander,
                                         const cf_provider_t *provider, void *provider_state) {
  (void)commander;  // groups are the caller's business, and a block does not hinder a stop
  provider->plan_stop(provider_state);
  return CF_OK;
}

cf_status_t cf_high_level_commander_go_to(cf_high_level_commander_t *commander,
                                          const cf_provider_t *provider, void *provider_state,
                                          struct vec position, float yaw, float duration,
                                          bool relative, bool linear, uint64_t now_us) {
  if (!isfinite(position.x) || !isfinite(position.y) || !isfinite(position.z) || !isfinite(yaw) ||
      !cf_high_level_is_positive(duration)) {
    return CF_ERR_VALUE;
  }
  if (commander->is_blocked) {
    return CF_ERR_BLOCKED;
  }
  const cf_plan_start_t from = cf_high_level_plan_start(commander);
  return cf_high_level_from_planner(provider->plan_go_to(provider_state, commander->memory, &from,
                                                         relative, linear, position, yaw, duration,
                                                         cf_high_level_seconds(now_us)));
}

cf_status_t cf_high_level_commander_spiral(cf_high_level_commander_t *commander,
                                           const cf_provider_t *provider, void *provider_state,
                                           const cf_spiral_t *spiral, uint64_t now_us) {
  if (!isfinite(spiral->angle) || !isfinite(spiral->radius0) || !isfinite(spiral->radiusF) ||
      !isfinite(spiral->ascent) || !cf_high_level_is_positive(spiral->duration)) {
    return CF_ERR_VALUE;
  }
  if (commander->is_blocked) {
    return CF_ERR_BLOCKED;
  }
  const cf_plan_start_t from = cf_high_level_plan_start(commander);
  return cf_high_level_from_planner(
      provider->plan_spiral(provider_state, &from, spiral, cf_high_level_seconds(now_us)));
}

bool cf_high_level_commander_is_trajectory_finished(const cf_high_level_commander_t *commander,
                                                    const cf_provider_t             *provider,
                                                    const void *provider_state, uint64_t now_us) {
  return provider->plan_is_finished(provider_state, commander->memory,
                                    cf_high_level_seconds(now_us));
}

void cf_high_level_commander_set_group_mask(cf_high_level_commander_t *commander, uint8_t mask) {
  commander->group_mask = mask;
}

bool cf_high_level_commander_is_in_group(const cf_high_level_commander_t *commander,
                                         uint8_t                          group) {
  return group == 0 || (group & commander->group_mask) != 0;
}

// A sum is finite only when all of its terms are; yaw is counted as it is written.
static bool is_finite_goal(const struct traj_eval *goal) {
  const float sum = (goal->pos.x + goal->pos.y + goal->pos.z) +
                    (goal->vel.x + goal->vel.y + goal->vel.z) +
                    (goal->acc.x + goal->acc.y + goal->acc.z) +
                    (goal->jerk.x + goal->jerk.y + goal->jerk.z) + degrees(goal->yaw);
  return isfinite(sum);
}

// Body rates [deg/s] of a goal, 0 where its thrust has no direction.
static attitude_t goal_rates(const struct traj_eval *goal) {
  const attitude_t rates = {
      .roll  = degrees(goal->omega.x),
      .pitch = degrees(goal->omega.y),
      .yaw   = degrees(goal->omega.z),
  };
  const bool exist = isfinite(rates.roll + rates.pitch + rates.yaw);
  return exist ? rates : (attitude_t){.roll = 0.0f};
}

// Writes a goal into the members of the setpoint that goals have; the others stay.
static void write_goal(setpoint_t *setpoint, const struct traj_eval *goal) {
  setpoint->position.x     = goal->pos.x;
  setpoint->position.y     = goal->pos.y;
  setpoint->position.z     = goal->pos.z;
  setpoint->velocity.x     = goal->vel.x;
  setpoint->velocity.y     = goal->vel.y;
  setpoint->velocity.z     = goal->vel.z;
  setpoint->acceleration.x = goal->acc.x;
  setpoint->acceleration.y = goal->acc.y;
  setpoint->acceleration.z = goal->acc.z;
  setpoint->jerk.x         = goal->jerk.x;
  setpoint->jerk.y         = goal->jerk.y;
  setpoint->jerk.z         = goal->jerk.z;
  setpoint->attitude.yaw   = degrees(goal->yaw);
  setpoint->attitudeRate   = goal_rates(goal);

  setpoint->mode = (setpoint_mode_t){
      .x     = modeAbs,
      .y     = modeAbs,
      .z     = modeAbs,
      .roll  = modeDisable,
      .pitch = modeDisable,
      .yaw   = modeAbs,
      .quat  = modeDisable,
  };
}

bool cf_high_level_commander_get_setpoint(cf_high_level_commander_t *commander,
                                          const cf_provider_t *provider, void *provider_state,
                                          const state_t *estimate, stabilizerStep_t step,
                                          uint64_t now_us, setpoint_t *setpoint) {
  if (step % (RATE_MAIN_LOOP / RATE_HL_COMMANDER) != 0) {
    return false;
  }

  const struct traj_eval goal =
      provider->plan_current_goal(provider_state, commander->memory, cf_high_level_seconds(now_us));

  // nothing is flown: the next plan starts where the vehicle is
  const bool stopped = provider->plan_is_stopped(provider_state);
  if (stopped || provider->plan_is_disabled(provider_state)) {
    cf_high_level_commander_tell_state(commander, estimate);
    if (stopped) {
      commander->setpoint = (setpoint_t){.timestamp = 0};
      *setpoint           = commander->setpoint;
    }
    return stopped;
  }

  if (!is_finite_goal(&goal)) {
    provider->plan_disable(provider_state);
    return false;
  }

  write_goal(&commander->setpoint, &goal);
  *setpoint      = commander->setpoint;
  commander->pos = goal.pos;
  commander->vel = goal.vel;
  commander->yaw = goal.yaw;
  return true;
}

void cf_high_level_commander_block(cf_high_level_commander_t *commander,
                                   const cf_provider_t *provider, void *provider_state,
                                   bool block) {
  const bool begins = block && !commander->is_blocked;
  if (begins && !provider->plan_is_disabled(provider_state)) {
    provider->plan_stop(provider_state);
  }
  commander->is_blocked = block;
}

void cf_high_level_commander_tell_state(cf_high_level_commander_t *commander,
                                        const state_t             *estimate) {
  commander->pos = mkvec(estimate->position.x, estimate->position.y, estimate->position.z);
  commander->vel = mkvec(estimate->velocity.x, estimate->velocity.y, estimate->velocity.z);
  commander->yaw = radians(estimate->attitude.yaw);
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("hlCommander", "vtoff", FLOAT, CF_CORE, cf_high_level_commander_t, vtoff),
    CF_ROW("hlCommander", "vland", FLOAT, CF_CORE, cf_high_level_commander_t, vland),
    CF_ROW("hlCommander", "groupmask", UINT8, CF_CORE, cf_high_level_commander_t, group_mask),
};

cf_variables_t cf_high_level_commander_parameters(void) {
  return (cf_variables_t){PARAMETERS, (int)(sizeof PARAMETERS / sizeof PARAMETERS[0]), 0};
}
