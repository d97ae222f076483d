#include "cffi/upstream_planner.h"

#include <stddef.h>

#include "api/math3d.h"
#include "builtin/planning/planner_pieces.h"
#include "builtin/planning/planner_spiral.h"

// returns its only piece
static struct poly4d *start_with_one_piece(struct piecewise_traj *pp) {
  pp->timescale = 1.0f;
  pp->shift     = vzero();
  pp->n_pieces  = 1;
  return (struct poly4d *)pp->pieces;
}

void cf_upstream_piecewise_plan_5th_order(struct piecewise_traj *pp, float duration, struct vec p0,
                                          float y0, struct vec v0, float dy0, struct vec a0,
                                          struct vec p1, float y1, struct vec v1, float dy1,
                                          struct vec a1) {
  piecewise_plan_5th_order(start_with_one_piece(pp), duration, p0, y0, v0, dy0, a0, p1, y1, v1, dy1,
                           a1);
}

void cf_upstream_piecewise_plan_7th_order_no_jerk(struct piecewise_traj *pp, float duration,
                                                  struct vec p0, float y0, struct vec v0, float dy0,
                                                  struct vec a0, struct vec p1, float y1,
                                                  struct vec v1, float dy1, struct vec a1) {
  piecewise_plan_7th_order_no_jerk(start_with_one_piece(pp), duration, p0, y0, v0, dy0, a0, p1, y1,
                                   v1, dy1, a1);
}

void plan_init(struct planner *p) {
  *p                           = (struct planner){.state = TRAJECTORY_STATE_IDLE};
  p->planned_trajectory.pieces = p->pieces;
}

void plan_stop(struct planner *p) {
  p->state = TRAJECTORY_STATE_IDLE;
}

bool plan_is_stopped(struct planner *p) {
  return p->state == TRAJECTORY_STATE_IDLE;
}

void plan_disable(struct planner *p) {
  p->state = TRAJECTORY_STATE_DISABLED;
}

bool plan_is_disabled(struct planner *p) {
  return p->state == TRAJECTORY_STATE_DISABLED;
}

bool plan_is_finished(struct planner *p, float t) {
  if (p->trajectory == NULL) {
    return true;
  }
  return p->type == TRAJECTORY_TYPE_PIECEWISE_COMPRESSED
             ? piecewise_compressed_is_finished(p->compressed_trajectory, t)
             : piecewise_is_finished(p->trajectory, t);
}

static struct traj_eval evaluate(struct planner *p, float t) {
  if (p->trajectory == NULL) {
    return traj_eval_invalid();
  }
  if (p->type == TRAJECTORY_TYPE_PIECEWISE_COMPRESSED) {
    return p->reversed ? traj_eval_invalid()
                       : piecewise_compressed_eval(p->compressed_trajectory, t);
  }
  return p->reversed ? piecewise_eval_reversed(p->trajectory, t) : piecewise_eval(p->trajectory, t);
}

struct traj_eval plan_current_goal(struct planner *p, float t) {
  if (plan_is_stopped(p) || plan_is_disabled(p)) {
    return traj_eval_invalid();
  }
  if (p->state == TRAJECTORY_STATE_LANDING && plan_is_finished(p, t)) {
    p->state = TRAJECTORY_STATE_IDLE;
  }
  return evaluate(p, t);
}

// makes pieces[0] the trajectory from t on
static void follow_planned(struct planner *p, enum trajectory_state state, float t) {
  p->planned_trajectory = (struct piecewise_traj){
      .t_begin   = t,
      .timescale = 1.0f,
      .n_pieces  = 1,
      .pieces    = p->pieces,
  };
  p->state      = state;
  p->type       = TRAJECTORY_TYPE_PIECEWISE;
  p->reversed   = false;
  p->trajectory = &p->planned_trajectory;
}

int plan_takeoff(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
                 float hover_yaw, float duration, float t) {
  if (p->state != TRAJECTORY_STATE_IDLE) {
    return 1;
  }
  cf_plan_vertical(&p->pieces[0], curr_pos, curr_yaw, hover_height, hover_yaw, duration);
  follow_planned(p, TRAJECTORY_STATE_FLYING, t);
  return 0;
}

int plan_land(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
              float hover_yaw, float duration, float t) {
  if (p->state == TRAJECTORY_STATE_LANDING) {
    return 1;
  }
  cf_plan_vertical(&p->pieces[0], curr_pos, curr_yaw, hover_height, hover_yaw, duration);
  follow_planned(p, TRAJECTORY_STATE_LANDING, t);
  return 0;
}

int plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                    bool linear, struct vec hover_pos, float hover_yaw, float duration, float t) {
  cf_plan_go_to(&p->pieces[0], curr_eval, relative, linear, hover_pos, hover_yaw, duration);
  follow_planned(p, TRAJECTORY_STATE_FLYING, t);
  return 0;
}

int plan_go_to(struct planner *p, bool relative, bool linear, struct vec hover_pos, float hover_yaw,
               float duration, float t) {
  const struct traj_eval curr_eval = plan_current_goal(p, t);
  return plan_go_to_from(p, &curr_eval, relative, linear, hover_pos, hover_yaw, duration, t);
}

int plan_spiral_from(struct planner *p, const struct traj_eval *curr_eval, bool sideways,
                     bool clockwise, float spiral_angle, float radius0, float radiusF, float ascent,
                     float duration, float t) {
  const cf_plan_start_t from = {
      .pos = curr_eval->pos, .vel = curr_eval->vel, .yaw = curr_eval->yaw};
  const cf_spiral_t spiral = {
      .sideways  = sideways,
      .clockwise = clockwise,
      .angle     = spiral_angle,
      .radius0   = radius0,
      .radiusF   = radiusF,
      .ascent    = ascent,
      .duration  = duration,
  };
  cf_plan_spiral(&p->pieces[0], &from, &spiral);
  follow_planned(p, TRAJECTORY_STATE_FLYING, t);
  return 0;
}

int plan_spiral(struct planner *p, bool sideways, bool clockwise, float spiral_angle, float radius0,
                float radiusF, float ascent, float duration, float t) {
  const struct traj_eval curr_eval = plan_current_goal(p, t);
  return plan_spiral_from(p, &curr_eval, sideways, clockwise, spiral_angle, radius0, radiusF,
                          ascent, duration, t);
}

int plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                          bool relative, bool relative_yaw, struct vec start_from,
                          float start_yaw) {
  p->state      = TRAJECTORY_STATE_FLYING;
  p->type       = TRAJECTORY_TYPE_PIECEWISE;
  p->reversed   = reversed;
  p->trajectory = trajectory;

  trajectory->shift     = vzero();
  trajectory->shift_yaw = 0.0f;
  if (!relative) {
    return 0;
  }
  const struct traj_eval first = evaluate(p, trajectory->t_begin);
  trajectory->shift            = vsub(start_from, first.pos);
  if (relative_yaw) {
    trajectory->shift_yaw =
        shortest_signed_angle_radians(normalize_radians(first.yaw), normalize_radians(start_yaw));
  }
  return 0;
}

int plan_start_compressed_trajectory(struct planner                   *p,
                                     struct piecewise_traj_compressed *trajectory, bool relative,
                                     struct vec start_from) {
  p->state                 = TRAJECTORY_STATE_FLYING;
  p->type                  = TRAJECTORY_TYPE_PIECEWISE_COMPRESSED;
  p->reversed              = false;
  p->compressed_trajectory = trajectory;

  trajectory->shift = vzero();
  if (relative) {
    const struct traj_eval first = piecewise_compressed_eval(trajectory, trajectory->t_begin);
    trajectory->shift            = vsub(start_from, first.pos);
  }
  return 0;
}
