#include "builtin/planning/planner.h"

#include <stddef.h>

#include "api/math3d.h"
#include "builtin/planning/planner_pieces.h"
#include "builtin/planning/planner_spiral.h"

void cf_planner_init(cf_planner_t *planner) {
  *planner = (cf_planner_t){.state = TRAJECTORY_STATE_IDLE, .source = CF_PLAN_NONE};
}

// A view of the current trajectory, valid for this call only.
static struct piecewise_traj current_trajectory(const cf_planner_t *planner,
                                                const uint8_t      *memory) {
  // trajectory memory holds whole pieces at offsets that are multiples of 4
  const struct poly4d *pieces = planner->source == CF_PLAN_UPLOADED
                                    ? (const struct poly4d *)(const void *)&memory[planner->offset]
                                    : &planner->planned;
  return (struct piecewise_traj){
      .t_begin   = planner->t_begin,
      .timescale = planner->timescale,
      .shift     = planner->shift,
      .shift_yaw = planner->shift_yaw,
      .n_pieces  = planner->n_pieces,
      .pieces    = pieces,
  };
}

// Moves the play-head, which stays in the planner.
static struct traj_eval evaluate_compressed(cf_planner_t *planner, const uint8_t *memory, float t) {
  struct piecewise_traj_compressed trajectory = {
      .t_begin       = planner->t_begin,
      .duration      = planner->duration,
      .timescale     = 1.0f,
      .shift         = planner->shift,
      .data          = &memory[planner->offset],
      .size          = CF_TRAJECTORY_MEMORY_BYTES - planner->offset,
      .current_piece = planner->current,
  };
  const struct traj_eval ev = piecewise_compressed_eval(&trajectory, t);
  planner->current          = trajectory.current_piece;
  return ev;
}

static struct traj_eval evaluate(cf_planner_t *planner, const uint8_t *memory, float t) {
  if (planner->source == CF_PLAN_COMPRESSED) {
    return evaluate_compressed(planner, memory, t);
  }
  const struct piecewise_traj trajectory = current_trajectory(planner, memory);
  return planner->reversed ? piecewise_eval_reversed(&trajectory, t)
                           : piecewise_eval(&trajectory, t);
}

// Makes the piece in `planned` the current trajectory.
static void follow_planned(cf_planner_t *planner, float t) {
  planner->source    = CF_PLAN_PLANNED;
  planner->reversed  = false;
  planner->t_begin   = t;
  planner->timescale = 1.0f;
  planner->shift     = vzero();
  planner->shift_yaw = 0.0f;
  planner->n_pieces  = 1;
}

// Straight up or down from rest to rest, for take-off and landing.
static void plan_vertical(cf_planner_t *planner, const cf_plan_start_t *from, float height,
                          float yaw, float duration, float t) {
  cf_plan_vertical(&planner->planned, from->pos, from->yaw, height, yaw, duration);
  follow_planned(planner, t);
}

int cf_planner_takeoff(cf_planner_t *planner, const cf_plan_start_t *from, float height, float yaw,
                       float duration, float t) {
  if (planner->state != TRAJECTORY_STATE_IDLE) {
    return 1;
  }
  plan_vertical(planner, from, height, yaw, duration, t);
  planner->state = TRAJECTORY_STATE_FLYING;
  return 0;
}

int cf_planner_land(cf_planner_t *planner, const cf_plan_start_t *from, float height, float yaw,
                    float duration, float t) {
  if (planner->state == TRAJECTORY_STATE_LANDING) {
    return 1;
  }
  plan_vertical(planner, from, height, yaw, duration, t);
  planner->state = TRAJECTORY_STATE_LANDING;
  return 0;
}

int cf_planner_go_to(cf_planner_t *planner, const uint8_t *memory, const cf_plan_start_t *from,
                     bool relative, bool linear, struct vec goal, float yaw, float duration,
                     float t) {
  // invalid while idle or disabled
  struct traj_eval start = cf_planner_current_goal(planner, memory, t);
  if (!is_traj_eval_valid(&start)) {
    start = (struct traj_eval){.pos = from->pos, .vel = from->vel, .yaw = from->yaw};
  }
  cf_plan_go_to(&planner->planned, &start, relative, linear, goal, yaw, duration);
  follow_planned(planner, t);
  planner->state = TRAJECTORY_STATE_FLYING;
  return 0;
}

int cf_planner_spiral(cf_planner_t *planner, const cf_plan_start_t *from, const cf_spiral_t *spiral,
                      float t) {
  cf_plan_spiral(&planner->planned, from, spiral);
  follow_planned(planner, t);
  planner->state = TRAJECTORY_STATE_FLYING;
  return 0;
}

// Puts the play-head on the first piece. False without a start record in the memory.
static bool load_compressed(cf_planner_t *planner, const uint8_t *memory, uint32_t offset) {
  const uint32_t size =
      offset < CF_TRAJECTORY_MEMORY_BYTES ? CF_TRAJECTORY_MEMORY_BYTES - offset : 0;
  struct piecewise_traj_compressed trajectory;
  piecewise_compressed_load(&trajectory, memory + (CF_TRAJECTORY_MEMORY_BYTES - size), size);
  if (trajectory.data == NULL) {
    return false;
  }
  planner->duration = trajectory.duration;
  planner->current  = trajectory.current_piece;
  return true;
}

int cf_planner_start_trajectory(cf_planner_t *planner, const uint8_t *memory,
                                const cf_uploaded_trajectory_t *trajectory,
                                const cf_plan_start_t *from, float t) {
  const bool is_compressed = trajectory->type == CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED;
  if (is_compressed && !load_compressed(planner, memory, trajectory->offset)) {
    return 1;
  }
  planner->state     = TRAJECTORY_STATE_FLYING;
  planner->source    = is_compressed ? CF_PLAN_COMPRESSED : CF_PLAN_UPLOADED;
  planner->reversed  = trajectory->reversed && !is_compressed;
  planner->t_begin   = t;
  planner->timescale = trajectory->timescale;
  planner->shift     = vzero();
  planner->shift_yaw = 0.0f;
  planner->offset    = trajectory->offset;
  planner->n_pieces  = trajectory->n_pieces;

  if (!trajectory->relative_position) {
    return 0;
  }
  // the shift is found before the turn: a turned trajectory that does not begin at the origin of
  // the world starts beside from->pos (docs/reference/planner-commander.md#6.6)
  const struct traj_eval first = evaluate(planner, memory, t);
  planner->shift               = vsub(from->pos, first.pos);
  if (trajectory->relative_yaw && !is_compressed) {
    planner->shift_yaw =
        shortest_signed_angle_radians(normalize_radians(first.yaw), normalize_radians(from->yaw));
  }
  return 0;
}

void cf_planner_stop(cf_planner_t *planner) {
  planner->state = TRAJECTORY_STATE_IDLE;
}

void cf_planner_disable(cf_planner_t *planner) {
  planner->state = TRAJECTORY_STATE_DISABLED;
}

bool cf_planner_is_stopped(const cf_planner_t *planner) {
  return planner->state == TRAJECTORY_STATE_IDLE;
}

bool cf_planner_is_disabled(const cf_planner_t *planner) {
  return planner->state == TRAJECTORY_STATE_DISABLED;
}

bool cf_planner_is_finished(const cf_planner_t *planner, const uint8_t *memory, float t) {
  if (planner->source == CF_PLAN_NONE) {
    return true;
  }
  if (planner->source == CF_PLAN_COMPRESSED) {
    return (t - planner->t_begin) >= planner->duration;
  }
  const struct piecewise_traj trajectory = current_trajectory(planner, memory);
  return piecewise_is_finished(&trajectory, t);
}

int cf_planner_state(const cf_planner_t *planner) {
  return (int)planner->state;
}

struct traj_eval cf_planner_current_goal(cf_planner_t *planner, const uint8_t *memory, float t) {
  if (cf_planner_is_stopped(planner) || cf_planner_is_disabled(planner)) {
    return traj_eval_invalid();
  }
  if (planner->state == TRAJECTORY_STATE_LANDING && cf_planner_is_finished(planner, memory, t)) {
    planner->state = TRAJECTORY_STATE_IDLE;
  }
  return evaluate(planner, memory, t);
}
