// Uploaded trajectories can be turned to the present yaw.
#include "planner.h"

int (*const start)(struct planner *, struct piecewise_traj *, bool, bool, bool, struct vec,
                   float) = plan_start_trajectory;
