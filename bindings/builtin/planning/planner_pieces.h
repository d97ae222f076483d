/* The planner's pieces for take-off, landing and go-to. Internal to C. */
#ifndef CF_BUILTIN_PLANNING_PLANNER_PIECES_H
#define CF_BUILTIN_PLANNING_PLANNER_PIECES_H

#include <stdbool.h>

#include "api/pptraj.h"

// Straight up or down from rest to rest, turning to yaw [rad] the short way round
// (docs/reference/planner-commander.md#6.3).
void cf_plan_vertical(struct poly4d *piece, struct vec from, float from_yaw, float height,
                      float yaw, float duration);

// From where `start` is and how it moves to rest at goal [m] and yaw [rad]; linear: at constant
// speed (docs/reference/planner-commander.md#6.4). Relative goals count from the start.
void cf_plan_go_to(struct poly4d *piece, const struct traj_eval *start, bool relative, bool linear,
                   struct vec goal, float yaw, float duration);

#endif  // CF_BUILTIN_PLANNING_PLANNER_PIECES_H
