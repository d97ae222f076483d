#include "api/pptraj.h"
#include "provider.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wmissing-braces"

const cf_provider_t *cf_provider(int i) {
  return NULL;
}

float polyval(const float p[8], float t) {
  return 0;
}

void polylinear(float p[8], float duration, float x0, float x1) {
}

void polybezier(float p[8], float duration, const float *x, int dim) {
}

void poly5(float p[8], float T, float x0, float v0, float a0, float xf, float vf, float af) {
}

void polyscale(float p[8], float s) {
}

void polyder(float p[8]) {
}

void polystretchtime(float p[8], float s) {
}

void polyreflect(float p[8]) {
}

struct poly4d poly4d_zero(float duration) {
  return (struct poly4d){0};
}

struct poly4d poly4d_linear(float duration, struct vec p0, struct vec p1, float yaw0, float yaw1) {
  return (struct poly4d){0};
}

void poly4d_scale(struct poly4d *p, float x, float y, float z, float yaw) {
}

void poly4d_shift(struct poly4d *p, float x, float y, float z, float yaw) {
}

void poly4d_shift_vec(struct poly4d *p, struct vec pos, float yaw) {
}

void poly4d_stretchtime(struct poly4d *p, float s) {
}

void polyder4d(struct poly4d *p) {
}

float poly4d_max_accel_approx(const struct poly4d *p) {
  return 0;
}

struct traj_eval poly4d_eval(const struct poly4d *p, float t) {
  return (struct traj_eval){0};
}

struct traj_eval traj_eval_zero(void) {
  return (struct traj_eval){0};
}

struct traj_eval traj_eval_invalid(void) {
  return (struct traj_eval){0};
}

bool is_traj_eval_valid(const struct traj_eval *ev) {
  return 0;
}

void traj_eval_transform(struct traj_eval *ev, struct vec shift, float rotation) {
}

float piecewise_duration(const struct piecewise_traj *traj) {
  return 0;
}

struct traj_eval piecewise_eval(const struct piecewise_traj *traj, float t) {
  return (struct traj_eval){0};
}

struct traj_eval piecewise_eval_reversed(const struct piecewise_traj *traj, float t) {
  return (struct traj_eval){0};
}

bool piecewise_is_finished(const struct piecewise_traj *traj, float t) {
  return 0;
}

void piecewise_plan_5th_order(struct poly4d *piece, float duration, struct vec p0, float y0,
                              struct vec v0, float dy0, struct vec a0, struct vec p1, float y1,
                              struct vec v1, float dy1, struct vec a1) {
}

void piecewise_plan_7th_order_no_jerk(struct poly4d *piece, float duration, struct vec p0, float y0,
                                      struct vec v0, float dy0, struct vec a0, struct vec p1,
                                      float y1, struct vec v1, float dy1, struct vec a1) {
}
