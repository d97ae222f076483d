/* The planner's spiral. Internal to C. */
#ifndef CF_BUILTIN_PLANNING_PLANNER_SPIRAL_H
#define CF_BUILTIN_PLANNING_PLANNER_SPIRAL_H

#include "api/pptraj.h"
#include "provider.h"

// Fills the one piece of a spiral that starts at from->pos and from->yaw
// (docs/reference/planner-commander.md#6.5).
void cf_plan_spiral(struct poly4d *piece, const cf_plan_start_t *from, const cf_spiral_t *spiral);

#endif  // CF_BUILTIN_PLANNING_PLANNER_SPIRAL_H
