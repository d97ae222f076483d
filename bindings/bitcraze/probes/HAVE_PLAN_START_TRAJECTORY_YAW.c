// Uploaded trajectories can be turned to the present yaw.
#include "planner.h"

int probe(struct planner *planner, struct piecewise_traj *trajectory, struct vec from);
int probe(struct planner *planner, struct piecewise_traj *trajectory, struct vec from) {
  return plan_start_trajectory(planner, trajectory, true, true, true, from, 0.0f);
}
