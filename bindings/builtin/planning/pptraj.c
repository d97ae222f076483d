/* Piecewise trajectories: which piece answers at t, and the one piece that the planner makes itself
 * (docs/reference/planner-commander.md#4.4, #4.7 and #4.8). */
#include "api/pptraj.h"

#include <string.h>

#include "api/math3d.h"

float piecewise_duration(const struct piecewise_traj *traj) {
  float total = 0.0f;
  for (int i = 0; i < traj->n_pieces; i++) {
    total += traj->pieces[i].duration;
  }
  return total * traj->timescale;
}

bool piecewise_is_finished(const struct piecewise_traj *traj, float t) {
  return (t - traj->t_begin) >= piecewise_duration(traj);
}

// At rest behind the end: position and yaw stay, everything that moves is zero.
static void come_to_rest(struct traj_eval *ev) {
  ev->vel   = vzero();
  ev->acc   = vzero();
  ev->jerk  = vzero();
  ev->omega = vzero();
}

struct traj_eval piecewise_eval(const struct piecewise_traj *traj, float t) {
  if (traj->n_pieces == 0) {
    return traj_eval_invalid();
  }

  t -= traj->t_begin;
  for (int i = 0; i < traj->n_pieces; i++) {
    // the end instant of a piece still belongs to it
    const float duration = traj->pieces[i].duration * traj->timescale;
    if (t <= duration) {
      struct poly4d piece = traj->pieces[i];
      poly4d_stretchtime(&piece, traj->timescale);
      struct traj_eval ev = poly4d_eval(&piece, t);
      traj_eval_transform(&ev, traj->shift, traj->shift_yaw);
      return ev;
    }
    t -= duration;
  }

  const struct poly4d *last = &traj->pieces[traj->n_pieces - 1];
  struct traj_eval     ev   = poly4d_eval(last, last->duration);
  traj_eval_transform(&ev, traj->shift, traj->shift_yaw);
  come_to_rest(&ev);
  return ev;
}

struct traj_eval piecewise_eval_reversed(const struct piecewise_traj *traj, float t) {
  if (traj->n_pieces == 0) {
    return traj_eval_invalid();
  }

  t -= traj->t_begin;
  for (int i = traj->n_pieces - 1; i >= 0; i--) {
    const float duration = traj->pieces[i].duration * traj->timescale;
    if (t <= duration) {
      struct poly4d piece = traj->pieces[i];
      poly4d_shift_vec(&piece, traj->shift, 0.0f);
      poly4d_stretchtime(&piece, traj->timescale);
      for (int axis = 0; axis < 4; axis++) {
        polyreflect(piece.p[axis]);
      }
      return poly4d_eval(&piece, t - duration);
    }
    t -= duration;
  }

  struct traj_eval ev = poly4d_eval(&traj->pieces[0], 0.0f);
  ev.pos              = vadd(ev.pos, traj->shift);
  come_to_rest(&ev);
  return ev;
}

// Degree 7 through position, velocity and acceleration at both ends, with zero jerk there.
static void poly7_no_jerk(float p[PP_SIZE], float T, float x0, float v0, float a0, float xf,
                          float vf, float af) {
  memset(p, 0, PP_SIZE * sizeof p[0]);
  if (T <= 0.0f) {
    p[0] = xf;
    p[1] = vf;
    p[2] = af / 2.0f;
    return;
  }

  const float T2 = T * T;
  const float T3 = T2 * T;
  const float T4 = T3 * T;
  const float T5 = T4 * T;
  const float T6 = T5 * T;
  const float T7 = T6 * T;
  p[0]           = x0;
  p[1]           = v0;
  p[2]           = a0 / 2.0f;
  p[4] = -(5.0f *
           (14.0f * x0 - 14.0f * xf + 8.0f * T * v0 + 6.0f * T * vf + 2.0f * T2 * a0 - T2 * af)) /
         (2.0f * T4);
  p[5] = (84.0f * x0 - 84.0f * xf + 45.0f * T * v0 + 39.0f * T * vf + 10.0f * T2 * a0 -
          7.0f * T2 * af) /
         T5;
  p[6] = -(140.0f * x0 - 140.0f * xf + 72.0f * T * v0 + 68.0f * T * vf + 15.0f * T2 * a0 -
           13.0f * T2 * af) /
         (2.0f * T6);
  p[7] =
      (2.0f * (10.0f * x0 - 10.0f * xf + 5.0f * T * v0 + 5.0f * T * vf + T2 * a0 - T2 * af)) / T7;
}

void piecewise_plan_5th_order(struct poly4d *piece, float duration, struct vec p0, float y0,
                              struct vec v0, float dy0, struct vec a0, struct vec p1, float y1,
                              struct vec v1, float dy1, struct vec a1) {
  piece->duration = duration;
  poly5(piece->p[0], duration, p0.x, v0.x, a0.x, p1.x, v1.x, a1.x);
  poly5(piece->p[1], duration, p0.y, v0.y, a0.y, p1.y, v1.y, a1.y);
  poly5(piece->p[2], duration, p0.z, v0.z, a0.z, p1.z, v1.z, a1.z);
  poly5(piece->p[3], duration, y0, dy0, 0.0f, y1, dy1, 0.0f);
}

void piecewise_plan_7th_order_no_jerk(struct poly4d *piece, float duration, struct vec p0, float y0,
                                      struct vec v0, float dy0, struct vec a0, struct vec p1,
                                      float y1, struct vec v1, float dy1, struct vec a1) {
  piece->duration = duration;
  poly7_no_jerk(piece->p[0], duration, p0.x, v0.x, a0.x, p1.x, v1.x, a1.x);
  poly7_no_jerk(piece->p[1], duration, p0.y, v0.y, a0.y, p1.y, v1.y, a1.y);
  poly7_no_jerk(piece->p[2], duration, p0.z, v0.z, a0.z, p1.z, v1.z, a1.z);
  poly7_no_jerk(piece->p[3], duration, y0, dy0, 0.0f, y1, dy1, 0.0f);
}
