// Go-to takes whether to fly straight.
#include "planner.h"

int probe(struct planner *planner, struct traj_eval *from, struct vec goal);
int probe(struct planner *planner, struct traj_eval *from, struct vec goal) {
  return plan_go_to_from(planner, from, true, true, goal, 0.0f, 1.0f, 0.0f);
}
