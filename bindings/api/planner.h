/* The planner's states, with the names of the firmware's planner.h
 * (docs/reference/planner-commander.md#6.1). */
#ifndef PLANNER_H
#define PLANNER_H

// Bit 0 is set while a plan is flown.
enum trajectory_state {
  TRAJECTORY_STATE_IDLE     = 0,  // motors off
  TRAJECTORY_STATE_FLYING   = 1,  // follow the plan, then hover at its end
  TRAJECTORY_STATE_LANDING  = 3,  // follow the plan, then motors off
  TRAJECTORY_STATE_DISABLED = 4,  // the planner makes no setpoint: another source flies
};

#endif  // PLANNER_H
