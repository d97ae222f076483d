// clang-format off
#include <stddef.h>
#include "planner.h"
// clang-format on

#if MINIATURE_RELEASE >= 202502
#define RATES(EV) ((EV)->omega)
#else
#define RATES(EV) ((EV)->rates)
#endif

static struct traj_eval plan_eval(struct planner *p, float t) {
  if (p->type == TRAJECTORY_TYPE_PIECEWISE_COMPRESSED) {
    return p->reversed ? traj_eval_invalid()
                       : piecewise_compressed_eval(p->compressed_trajectory, t);
  }
  return p->reversed ? piecewise_eval_reversed(p->trajectory, t) : piecewise_eval(p->trajectory, t);
}

void plan_init(struct planner *p) {
  p->state                     = TRAJECTORY_STATE_IDLE;
  p->type                      = TRAJECTORY_TYPE_PIECEWISE;
  p->reversed                  = false;
  p->trajectory                = NULL;
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
#if MINIATURE_RELEASE >= 202502
  if (p->trajectory == NULL) {
    return true;
  }
#endif
  if (p->type == TRAJECTORY_TYPE_PIECEWISE_COMPRESSED) {
    return piecewise_compressed_is_finished(p->compressed_trajectory, t);
  }
  return piecewise_is_finished(p->trajectory, t);
}

struct traj_eval plan_current_goal(struct planner *p, float t) {
  switch (p->state) {
    case TRAJECTORY_STATE_LANDING:
      if (plan_is_finished(p, t)) {
        p->state = TRAJECTORY_STATE_IDLE;
      }
      return plan_eval(p, t);
    case TRAJECTORY_STATE_FLYING:
      return plan_eval(p, t);
    default:
      return traj_eval_invalid();
  }
}

static void follow_planned(struct planner *p, float t) {
  p->reversed                   = false;
  p->type                       = TRAJECTORY_TYPE_PIECEWISE;
  p->planned_trajectory.t_begin = t;
  p->trajectory                 = &p->planned_trajectory;
}

static void plan_vertical(struct planner *p, struct vec pos, float yaw, float height,
                          float hover_yaw, float duration, float t) {
  const float start = normalize_radians(yaw);
  const float goal  = start + shortest_signed_angle_radians(start, normalize_radians(hover_yaw));
  piecewise_plan_7th_order_no_jerk(&p->planned_trajectory, duration, pos, start, vzero(), 0,
                                   vzero(), mkvec(pos.x, pos.y, height), goal, vzero(), 0, vzero());
  follow_planned(p, t);
}

int plan_takeoff(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
                 float hover_yaw, float duration, float t) {
  if (p->state != TRAJECTORY_STATE_IDLE) {
    return 1;
  }
  plan_vertical(p, curr_pos, curr_yaw, hover_height, hover_yaw, duration, t);
  p->state = TRAJECTORY_STATE_FLYING;
  return 0;
}

int plan_land(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
              float hover_yaw, float duration, float t) {
  if (p->state == TRAJECTORY_STATE_LANDING) {
    return 1;
  }
  plan_vertical(p, curr_pos, curr_yaw, hover_height, hover_yaw, duration, t);
  p->state = TRAJECTORY_STATE_LANDING;
  return 0;
}

static int go_to(struct planner *p, const struct traj_eval *from, bool relative, bool linear,
                 struct vec goal, float yaw, float duration, float t) {
  if (relative) {
    goal = vadd(goal, from->pos);
    yaw += from->yaw;
  }
  const float start = normalize_radians(from->yaw);
  const float turn  = shortest_signed_angle_radians(start, normalize_radians(yaw));
  if (linear) {
    const struct vec v  = vdiv(vsub(goal, from->pos), duration);
    const float      dy = turn / duration;
    piecewise_plan_7th_order_no_jerk(&p->planned_trajectory, duration, from->pos, start, v, dy,
                                     vzero(), goal, start + turn, v, dy, vzero());
  } else {
    piecewise_plan_7th_order_no_jerk(&p->planned_trajectory, duration, from->pos, start, from->vel,
                                     RATES(from).z, from->acc, goal, start + turn, vzero(), 0,
                                     vzero());
  }
  follow_planned(p, t);
  p->state = TRAJECTORY_STATE_FLYING;
  return 0;
}

#if MINIATURE_RELEASE >= 202502
int plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                    bool linear, struct vec hover_pos, float hover_yaw, float duration, float t) {
  return go_to(p, curr_eval, relative, linear, hover_pos, hover_yaw, duration, t);
}

int plan_go_to(struct planner *p, bool relative, bool linear, struct vec hover_pos, float hover_yaw,
               float duration, float t) {
  const struct traj_eval now = plan_current_goal(p, t);
  return go_to(p, &now, relative, linear, hover_pos, hover_yaw, duration, t);
}

// one end of a spiral, seen from its axis
struct spiral_end {
  struct vec offset, vel, acc;
};

static struct spiral_end spiral_end(bool sideways, float sign, float w, float dr, float climb,
                                    float r, float yaw) {
  const float c = cosf(yaw), s = sinf(yaw);
  if (sideways) {
    return (struct spiral_end){
        mkvec(-sign * r * c, -sign * r * s, 0),
        mkvec(sign * (r * s * w - dr * c), sign * (-r * c * w - dr * s), climb),
        mkvec(sign * (r * c * w * w + 2 * dr * s * w), sign * (r * s * w * w - 2 * dr * c * w), 0)};
  }
  return (struct spiral_end){
      mkvec(-sign * r * s, sign * r * c, 0),
      mkvec(-sign * (r * c * w + dr * s), sign * (-r * s * w + dr * c), climb),
      mkvec(sign * (r * s * w * w - 2 * dr * c * w), sign * (-r * c * w * w - 2 * dr * s * w), 0)};
}

int plan_spiral_from(struct planner *p, const struct traj_eval *curr_eval, bool sideways,
                     bool clockwise, float spiral_angle, float radius0, float radiusF, float ascent,
                     float duration, float t) {
  const float full  = 2.0f * M_PI_F;
  const float angle = fminf(fmaxf(spiral_angle, -full), full);
  const float r0 = fmaxf(radius0, 0), rF = fmaxf(radiusF, 0);
  const float sign = clockwise ? 1.0f : -1.0f;
  const float w = -sign * angle / duration, dr = (rF - r0) / duration, climb = ascent / duration;

  const float             yaw0  = normalize_radians(curr_eval->yaw);
  const float             yawF  = yaw0 - sign * angle;
  const struct spiral_end begin = spiral_end(sideways, sign, w, dr, climb, r0, yaw0);
  const struct spiral_end end   = spiral_end(sideways, sign, w, dr, climb, rF, yawF);
  const struct vec        axis  = vsub(curr_eval->pos, begin.offset);
  const struct vec        goal  = vadd(vadd(axis, end.offset), mkvec(0, 0, ascent));
  piecewise_plan_7th_order_no_jerk(&p->planned_trajectory, duration, curr_eval->pos, yaw0,
                                   begin.vel, w, begin.acc, goal, yawF, end.vel, w, end.acc);
  follow_planned(p, t);
  p->state = TRAJECTORY_STATE_FLYING;
  return 0;
}

int plan_spiral(struct planner *p, bool sideways, bool clockwise, float spiral_angle, float radius0,
                float radiusF, float ascent, float duration, float t) {
  const struct traj_eval now = plan_current_goal(p, t);
  return plan_spiral_from(p, &now, sideways, clockwise, spiral_angle, radius0, radiusF, ascent,
                          duration, t);
}
#else
int plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                    struct vec hover_pos, float hover_yaw, float duration, float t) {
  return go_to(p, curr_eval, relative, false, hover_pos, hover_yaw, duration, t);
}

int plan_go_to(struct planner *p, bool relative, struct vec hover_pos, float hover_yaw,
               float duration, float t) {
  const struct traj_eval now = plan_current_goal(p, t);
  return go_to(p, &now, relative, false, hover_pos, hover_yaw, duration, t);
}
#endif

static void follow(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                   bool relative, struct vec start_from) {
  p->reversed       = reversed;
  p->state          = TRAJECTORY_STATE_FLYING;
  p->type           = TRAJECTORY_TYPE_PIECEWISE;
  p->trajectory     = trajectory;
  trajectory->shift = vzero();
  if (relative) {
    const struct traj_eval first = plan_eval(p, trajectory->t_begin);
    trajectory->shift            = vsub(start_from, first.pos);
  }
}

#if MINIATURE_RELEASE >= 202608
int plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                          bool relative, bool relative_yaw, struct vec start_from,
                          float start_yaw) {
  trajectory->shift_yaw = 0;
  follow(p, trajectory, reversed, relative, start_from);
  if (relative && relative_yaw) {
    const float first     = normalize_radians(plan_eval(p, trajectory->t_begin).yaw);
    trajectory->shift_yaw = shortest_signed_angle_radians(first, normalize_radians(start_yaw));
  }
  return 0;
}
#else
int plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                          bool relative, struct vec start_from) {
  follow(p, trajectory, reversed, relative, start_from);
  return 0;
}
#endif

int plan_start_compressed_trajectory(struct planner                   *p,
                                     struct piecewise_traj_compressed *trajectory, bool relative,
                                     struct vec start_from) {
  p->reversed              = false;
  p->state                 = TRAJECTORY_STATE_FLYING;
  p->type                  = TRAJECTORY_TYPE_PIECEWISE_COMPRESSED;
  p->compressed_trajectory = trajectory;
  trajectory->shift        = vzero();
  if (relative) {
    const struct traj_eval first = plan_eval(p, trajectory->t_begin);
    trajectory->shift            = vsub(start_from, first.pos);
  }
  return 0;
}
