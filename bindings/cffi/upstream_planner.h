/* The planner in upstream's form, with pointers to its trajectories, over provider builtin, for
 * scripts that call it by upstream's names (crazychoir_fw.cffirmware). A drone uses
 * builtin/planning/planner.h, which plans the same pieces without pointers.
 *
 * Source: docs/reference/planner-commander.md#6. Meters, radians, float32 seconds. Functions that
 * return int return 0 when the plan was made, 1 when it was refused. */
#ifndef CF_CFFI_UPSTREAM_PLANNER_H
#define CF_CFFI_UPSTREAM_PLANNER_H

#include <stdbool.h>

#include "api/planner.h"
#include "api/pptraj.h"
#include "api/pptraj_compressed.h"

enum trajectory_type {
  TRAJECTORY_TYPE_PIECEWISE            = 0,
  TRAJECTORY_TYPE_PIECEWISE_COMPRESSED = 1,
};

struct planner {
  enum trajectory_state state;
  enum trajectory_type  type;
  bool                  reversed;
  union {
    struct piecewise_traj            *trajectory;  // null before the first plan
    struct piecewise_traj_compressed *compressed_trajectory;
  };
  struct piecewise_traj planned_trajectory;  // of pieces[0]
  struct poly4d         pieces[1];           // of a take-off, landing, go-to or spiral
};

// Plan pieces[0], which must be there, and make it all of the trajectory; t_begin and shift_yaw
// stay.
void cf_upstream_piecewise_plan_5th_order(struct piecewise_traj *pp, float duration, struct vec p0,
                                          float y0, struct vec v0, float dy0, struct vec a0,
                                          struct vec p1, float y1, struct vec v1, float dy1,
                                          struct vec a1);
void cf_upstream_piecewise_plan_7th_order_no_jerk(struct piecewise_traj *pp, float duration,
                                                  struct vec p0, float y0, struct vec v0, float dy0,
                                                  struct vec a0, struct vec p1, float y1,
                                                  struct vec v1, float dy1, struct vec a1);

void plan_init(struct planner *p);
void plan_stop(struct planner *p);
bool plan_is_stopped(struct planner *p);
void plan_disable(struct planner *p);
bool plan_is_disabled(struct planner *p);
bool plan_is_finished(struct planner *p, float t);

// Returns the goal at t, invalid while stopped or disabled. The planner stops when a landing has
// ended; that call still returns its goal.
struct traj_eval plan_current_goal(struct planner *p, float t);

int plan_takeoff(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
                 float hover_yaw, float duration, float t);
int plan_land(struct planner *p, struct vec curr_pos, float curr_yaw, float hover_height,
              float hover_yaw, float duration, float t);

// Starts at the current goal, also when that is invalid.
int plan_go_to(struct planner *p, bool relative, bool linear, struct vec hover_pos, float hover_yaw,
               float duration, float t);
int plan_go_to_from(struct planner *p, const struct traj_eval *curr_eval, bool relative,
                    bool linear, struct vec hover_pos, float hover_yaw, float duration, float t);

int plan_spiral(struct planner *p, bool sideways, bool clockwise, float spiral_angle, float radius0,
                float radiusF, float ascent, float duration, float t);
int plan_spiral_from(struct planner *p, const struct traj_eval *curr_eval, bool sideways,
                     bool clockwise, float spiral_angle, float radius0, float radiusF, float ascent,
                     float duration, float t);

// The trajectory must outlive the planner's use of it, and says when it begins. relative shifts its
// first point to start_from, relative_yaw (with relative) turns its first yaw to start_yaw.
int plan_start_trajectory(struct planner *p, struct piecewise_traj *trajectory, bool reversed,
                          bool relative, bool relative_yaw, struct vec start_from, float start_yaw);
int plan_start_compressed_trajectory(struct planner                   *p,
                                     struct piecewise_traj_compressed *trajectory, bool relative,
                                     struct vec start_from);

#endif  // CF_CFFI_UPSTREAM_PLANNER_H
