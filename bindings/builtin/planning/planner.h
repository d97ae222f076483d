/* The onboard planner: turns take-off, landing, go-to and uploaded trajectories into a goal at t.
 *
 * The functions have the form of the plan_* entries of a provider. Times are float32 seconds,
 * angles radians; functions returning int return 0 when the plan was made and 1 when refused.
 * `memory` is the trajectory memory: CF_TRAJECTORY_MEMORY_BYTES, aligned to 4, the same bytes at
 * every call. Uncompressed pieces must lie in it at an offset that is a multiple of 4 (the
 * high-level commander checks that); compressed ones are checked here, at every read.
 *
 * Source: docs/reference/planner-commander.md#6. */
#ifndef CF_BUILTIN_PLANNING_PLANNER_H
#define CF_BUILTIN_PLANNING_PLANNER_H

#include <stdbool.h>
#include <stdint.h>

#include "api/planner.h"
#include "api/pptraj.h"
#include "api/pptraj_compressed.h"
#include "provider.h"

typedef enum {
  CF_PLAN_NONE       = 0,  // nothing was ever planned
  CF_PLAN_PLANNED    = 1,  // the piece in `planned`
  CF_PLAN_UPLOADED   = 2,  // pieces in trajectory memory
  CF_PLAN_COMPRESSED = 3,  // compressed pieces in trajectory memory
} cf_plan_source_t;

typedef struct {
  enum trajectory_state state;
  cf_plan_source_t      source;  // where the pieces are
  bool                  reversed;

  // the current trajectory
  float      t_begin;    // [s]
  float      timescale;  // > 1 slows down
  struct vec shift;      // [m]
  float      shift_yaw;  // [rad], about the origin of the world, before the shift
  uint32_t   offset;     // [bytes] in trajectory memory, when uploaded
  uint8_t    n_pieces;
  float      duration;  // [s], when compressed

  union {
    struct poly4d planned;  // the one piece of a take-off, landing, go-to or spiral
    struct piecewise_traj_compressed_piece current;  // play-head of a compressed trajectory
  };
} cf_planner_t;

// Idle, with no trajectory.
void cf_planner_init(cf_planner_t *planner);

// Plan a rise from rest to height [m] above the world's origin, straight up, turning to yaw.
// Refused unless idle.
int cf_planner_takeoff(cf_planner_t *planner, const cf_plan_start_t *from, float height, float yaw,
                       float duration, float t);

// Plan the same downwards; the planner becomes idle at its end. Refused while landing.
int cf_planner_land(cf_planner_t *planner, const cf_plan_start_t *from, float height, float yaw,
                    float duration, float t);

// Plan a flight to goal [m] and yaw: smooth, or linear at constant speed. Starts at the current
// goal, or at `from` (without acceleration) when idle or disabled, or when the current goal is not
// a number. Relative goals count from there.
int cf_planner_go_to(cf_planner_t *planner, const uint8_t *memory, const cf_plan_start_t *from,
                     bool relative, bool linear, struct vec goal, float yaw, float duration,
                     float t);

// Plan a spiral that starts at from->pos with its own speed. Angles beyond a full turn become one,
// negative radii 0.
int cf_planner_spiral(cf_planner_t *planner, const cf_plan_start_t *from, const cf_spiral_t *spiral,
                      float t);

// Follow pieces of trajectory memory from t on. `relative_position` moves the first point to
// from->pos; with it, `relative_yaw` turns the trajectory about the world's origin until it starts
// at from->yaw (no effect when reversed). Refused when a compressed start record does not lie in
// the memory.
int cf_planner_start_trajectory(cf_planner_t *planner, const uint8_t *memory,
                                const cf_uploaded_trajectory_t *trajectory,
                                const cf_plan_start_t *from, float t);

void cf_planner_stop(cf_planner_t *planner);
void cf_planner_disable(cf_planner_t *planner);
bool cf_planner_is_stopped(const cf_planner_t *planner);
bool cf_planner_is_disabled(const cf_planner_t *planner);

// True behind the end of the trajectory, and before there is one.
bool cf_planner_is_finished(const cf_planner_t *planner, const uint8_t *memory, float t);

int cf_planner_state(const cf_planner_t *planner);  // enum trajectory_state

// Returns the goal at t, or traj_eval_invalid() when idle or disabled. Makes the planner idle when
// a landing has ended; that call still returns its goal.
struct traj_eval cf_planner_current_goal(cf_planner_t *planner, const uint8_t *memory, float t);

#endif  // CF_BUILTIN_PLANNING_PLANNER_H
