// Go-to takes whether to fly straight.
#include "planner.h"

int (*const go_to)(struct planner *, const struct traj_eval *, bool, bool, struct vec, float, float,
                   float) = plan_go_to_from;
