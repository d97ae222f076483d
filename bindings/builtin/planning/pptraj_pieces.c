/* Pieces of a trajectory: x, y, z and yaw together, and what a quadrotor must do to follow them
 * (docs/reference/planner-commander.md#4.5 and #4.6). */
#include <math.h>

#include "api/math3d.h"
#include "api/pptraj.h"

#define AXES 4
#define GRAVITY 9.81f  // [m/s^2]

// [samples], bounds the loop of poly4d_max_accel_approx for absurd durations
#define MAX_SAMPLES 1000000.0f

struct poly4d poly4d_zero(float duration) {
  return (struct poly4d){.duration = duration};
}

struct poly4d poly4d_linear(float duration, struct vec p0, struct vec p1, float yaw0, float yaw1) {
  struct poly4d p = poly4d_zero(duration);
  polylinear(p.p[0], duration, p0.x, p1.x);
  polylinear(p.p[1], duration, p0.y, p1.y);
  polylinear(p.p[2], duration, p0.z, p1.z);
  polylinear(p.p[3], duration, yaw0, yaw1);
  return p;
}

void poly4d_scale(struct poly4d *p, float x, float y, float z, float yaw) {
  polyscale(p->p[0], x);
  polyscale(p->p[1], y);
  polyscale(p->p[2], z);
  polyscale(p->p[3], yaw);
}

void poly4d_shift(struct poly4d *p, float x, float y, float z, float yaw) {
  p->p[0][0] += x;
  p->p[1][0] += y;
  p->p[2][0] += z;
  p->p[3][0] += yaw;
}

void poly4d_shift_vec(struct poly4d *p, struct vec pos, float yaw) {
  poly4d_shift(p, pos.x, pos.y, pos.z, yaw);
}

void poly4d_stretchtime(struct poly4d *p, float s) {
  for (int axis = 0; axis < AXES; axis++) {
    polystretchtime(p->p[axis], s);
  }
  p->duration *= s;
}

void polyder4d(struct poly4d *p) {
  for (int axis = 0; axis < AXES; axis++) {
    polyder(p->p[axis]);
  }
}

static struct vec polyval_xyz(const struct poly4d *p, float t) {
  return mkvec(polyval(p->p[0], t), polyval(p->p[1], t), polyval(p->p[2], t));
}

float poly4d_max_accel_approx(const struct poly4d *p) {
  struct poly4d acc = *p;
  polyder4d(&acc);
  polyder4d(&acc);

  const float wanted = 10.0f * p->duration;
  if (!(wanted >= 1.0f)) {
    return 0.0f;
  }
  const int   steps = (int)fminf(wanted, MAX_SAMPLES);
  const float step  = p->duration / (float)(steps - 1);

  float t   = 0.0f;
  float max = 0.0f;
  for (int i = 0; i < steps; i++) {
    max = fmaxf(max, vnorm1(polyval_xyz(&acc, t)));
    t += step;
  }
  return max;
}

// Body rates of a vehicle whose thrust follows acc and whose nose follows yaw.
static struct vec body_rates(struct vec acc, struct vec jerk, float yaw, float dyaw) {
  const struct vec thrust = vadd(acc, mkvec(0.0f, 0.0f, GRAVITY));

  const struct vec z_body  = vnormalize(thrust);
  const struct vec x_world = mkvec(cosf(yaw), sinf(yaw), 0.0f);
  const struct vec y_body  = vnormalize(vcross(z_body, x_world));
  const struct vec x_body  = vcross(y_body, z_body);

  const struct vec h = vdiv(vorthunit(jerk, z_body), vmag(thrust));
  return mkvec(-vdot(h, y_body), vdot(h, x_body), z_body.z * dyaw);
}

struct traj_eval poly4d_eval(const struct poly4d *p, float t) {
  struct traj_eval out = {.pos = polyval_xyz(p, t), .yaw = polyval(p->p[3], t)};

  struct poly4d derivative = *p;
  polyder4d(&derivative);
  out.vel          = polyval_xyz(&derivative, t);
  const float dyaw = polyval(derivative.p[3], t);

  polyder4d(&derivative);
  out.acc = polyval_xyz(&derivative, t);

  polyder4d(&derivative);
  out.jerk = polyval_xyz(&derivative, t);

  out.omega = body_rates(out.acc, out.jerk, out.yaw, dyaw);
  return out;
}

struct traj_eval traj_eval_zero(void) {
  return (struct traj_eval){.yaw = 0.0f};
}

struct traj_eval traj_eval_invalid(void) {
  return (struct traj_eval){.pos = {NAN, NAN, NAN}};
}

bool is_traj_eval_valid(const struct traj_eval *ev) {
  return !visnan(ev->pos);
}

void traj_eval_transform(struct traj_eval *ev, struct vec shift, float rotation) {
  const float        angle = normalize_radians(rotation);
  const struct mat33 turn  = mrotz(angle);
  ev->pos                  = vadd(mvmul(turn, ev->pos), shift);
  ev->vel                  = mvmul(turn, ev->vel);
  ev->acc                  = mvmul(turn, ev->acc);
  ev->yaw += angle;
}
