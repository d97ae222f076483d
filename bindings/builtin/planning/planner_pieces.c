#include "builtin/planning/planner_pieces.h"

#include "api/math3d.h"

void cf_plan_vertical(struct poly4d *piece, struct vec from, float from_yaw, float height,
                      float yaw, float duration) {
  const struct vec goal      = mkvec(from.x, from.y, height);
  const float      start_yaw = normalize_radians(from_yaw);
  const float      turn      = shortest_signed_angle_radians(start_yaw, normalize_radians(yaw));
  piecewise_plan_7th_order_no_jerk(piece, duration, from, start_yaw, vzero(), 0.0f, vzero(), goal,
                                   start_yaw + turn, vzero(), 0.0f, vzero());
}

void cf_plan_go_to(struct poly4d *piece, const struct traj_eval *start, bool relative, bool linear,
                   struct vec goal, float yaw, float duration) {
  if (relative) {
    goal = vadd(goal, start->pos);
    yaw += start->yaw;
  }
  const float start_yaw = normalize_radians(start->yaw);
  const float turn      = shortest_signed_angle_radians(start_yaw, normalize_radians(yaw));
  const float goal_yaw  = start_yaw + turn;

  if (linear) {
    const struct vec velocity = vdiv(vsub(goal, start->pos), duration);
    const float      yaw_rate = turn / duration;
    piecewise_plan_7th_order_no_jerk(piece, duration, start->pos, start_yaw, velocity, yaw_rate,
                                     vzero(), goal, goal_yaw, velocity, yaw_rate, vzero());
  } else {
    piecewise_plan_7th_order_no_jerk(piece, duration, start->pos, start_yaw, start->vel,
                                     start->omega.z, start->acc, goal, goal_yaw, vzero(), 0.0f,
                                     vzero());
  }
}
