// What a trajectory evaluates to has body rates.
// clang-format off: headers use what comes before
#include "math3d.h"
#include "pptraj.h"
// clang-format on

struct vec probe(struct traj_eval ev);
struct vec probe(struct traj_eval ev) {
  return ev.omega;
}
