#pragma once

#include <stdint.h>

#include "math3d.h"
#include "pptraj.h"
#include "pptraj_compressed.h"

enum trajectory_state {
  TRAJECTORY_STATE_IDLE     = 0,
  TRAJECTORY_STATE_FLYING   = 1,
  TRAJECTORY_STATE_LANDING  = 3,
  TRAJECTORY_STATE_DISABLED = 4,
};

enum trajectory_type {
  TRAJECTORY_TYPE_PIECEWISE            = 0,
  TRAJECTORY_TYPE_PIECEWISE_COMPRESSED = 1,
};

struct planner {
  enum trajectory_state state;
  enum trajectory_type  type;
  bool                  reversed;
  union {
    const struct piecewise_traj      *trajectory;
    struct piecewise_traj_compressed *compressed_trajectory;
  };
  struct piecewise_traj planned_trajectory;
  struct poly4d         pieces[1];  // of the planned trajectory
};

void             plan_init(struct planner *p);
void             plan_stop(struct planner *p);
bool             plan_is_stopped(struct planner *p);
void             plan_disable(struct planner *p);
bool             plan_is_disabled(struct planner *p);
bool             plan_is_finished(struct planner *p, float t);
struct traj_eval plan_current_goal(struct planner *p, float t);

int plan_takeoff(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
                 float hover_yaw, float duration, float t);
int plan_land(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
              float hover_yaw, float duration, float t);
#if MINIATURE_RELEASE >= 202502
int plan_go_to(struct planner *p, bool relative, bool linear, struct vec hover_pos, float hover_yaw,
               float duration, float t);
int plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                    bool linear, struct vec hover_pos, float hover_yaw, float duration, float t);
int plan_spiral(struct planner *p, bool sideways, bool clockwise, float spiral_angle, float radius0,
                float radiusF, float ascent, float duration, float t);
int plan_spiral_from(struct planner *p, const struct traj_eval *curr_eval, bool sideways,
                     bool clockwise, float spiral_angle, float radius0, float radiusF, float ascent,
                     float duration, float t);
#else
int plan_go_to(struct planner *p, bool relative, struct vec hover_pos, float hover_yaw,
               float duration, float t);
int plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                    struct vec hover_pos, float hover_yaw, float duration, float t);
#endif
#if MINIATURE_RELEASE >= 202608
int plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                          bool relative, bool relative_yaw, struct vec start_from, float start_yaw);
#else
int plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                          bool relative, struct vec start_from);
#endif
int plan_start_compressed_trajectory(struct planner                   *p,
                                     struct piecewise_traj_compressed *trajectory, bool relative,
                                     struct vec start_from);
