#include "mujoco_plugin/forces.h"

static void multiply3(const double m[9], const double v[3], double out[3]) {
  for (int i = 0; i < 3; i++) {
    out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
  }
}

static void gyroscopic_torque(const drone_t *drone, const double rates[3], double out[3]) {
  double momentum[3];
  multiply3(drone->inertia, rates, momentum);
  out[0] = rates[1] * momentum[2] - rates[2] * momentum[1];
  out[1] = rates[2] * momentum[0] - rates[0] * momentum[2];
  out[2] = rates[0] * momentum[1] - rates[1] * momentum[0];
}

// MuJoCo's Euler step takes the gyroscopic torque g(w) = w x Jw at the start of the step, which
// makes a tumbling body gain energy. Taking it at the middle, w_h = w + dt/2 J^-1 (torque - g(w)),
// repairs that: add g(w) - g(w_h).
static void add_midpoint_gyroscopics(const drone_t *drone, const double rates[3], double timestep,
                                     double torque[3]) {
  double now[3], acceleration[3], middle[3], later[3], net[3];
  gyroscopic_torque(drone, rates, now);
  for (int i = 0; i < 3; i++) {
    net[i] = torque[i] - now[i];
  }
  multiply3(drone->inverse_inertia, net, acceleration);
  for (int i = 0; i < 3; i++) {
    middle[i] = rates[i] + 0.5 * timestep * acceleration[i];
  }
  gyroscopic_torque(drone, middle, later);
  for (int i = 0; i < 3; i++) {
    torque[i] += now[i] - later[i];
  }
}

void cf_forces_of(const mjModel *model, const drone_t *drone, const cf_t *cf,
                  const cf_motion_t *motion, const double rates[3], double out[6]) {
  float force[3];
  float torque[3];
  cf_wrench(cf, motion, force, torque);
  for (int i = 0; i < 3; i++) {
    out[i]     = (double)force[i];
    out[3 + i] = (double)torque[i];
  }
  if (model->opt.integrator == mjINT_EULER) {
    add_midpoint_gyroscopics(drone, rates, model->opt.timestep, out + 3);
  }
}
