// The planner knows spirals.
#include "planner.h"

int (*const spiral)(struct planner *, const struct traj_eval *, bool, bool, float, float, float,
                    float, float, float) = plan_spiral_from;
