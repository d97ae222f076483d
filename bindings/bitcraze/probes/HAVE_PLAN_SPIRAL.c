// The planner knows spirals.
#include "planner.h"

int probe(struct planner *planner, struct traj_eval *from);
int probe(struct planner *planner, struct traj_eval *from) {
  return plan_spiral_from(planner, from, true, true, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 0.0f);
}
