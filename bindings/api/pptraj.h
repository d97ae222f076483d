/* Piecewise polynomial trajectories: types and functions with the names of the firmware's pptraj.h.
 *
 * Source: docs/reference/planner-commander.md#4. Meters, seconds, radians. */
#ifndef PPTRAJ_H
#define PPTRAJ_H

#include <stdbool.h>

#include "api/vec.h"

#define PP_DEGREE 7
#define PP_SIZE 8

// One piece: x, y, z and yaw as polynomials of degree 7 in ascending powers. 132 bytes, also the
// wire format.
struct poly4d {
  float p[4][8];
  float duration;  // [s]
};

struct traj_eval {
  struct vec pos;    // [m]
  struct vec vel;    // [m/s]
  struct vec acc;    // [m/s^2]
  struct vec jerk;   // [m/s^3]
  struct vec omega;  // [rad/s], body rates
  float      yaw;    // [rad]
};

// A view of pieces that live elsewhere (in trajectory memory): made on the stack, never part of a
// drone's state.
struct piecewise_traj {
  float                t_begin;    // [s]
  float                timescale;  // > 1 slows down
  struct vec           shift;      // [m]
  float                shift_yaw;  // [rad]
  unsigned char        n_pieces;
  const struct poly4d *pieces;
};

// Polynomials in one variable: p[k] belongs to t^k.
float polyval(const float p[8], float t);
void  polylinear(float p[8], float duration, float x0, float x1);
void  polybezier(float p[8], float duration, const float *x, int dim);
void  poly5(float p[8], float T, float x0, float v0, float a0, float xf, float vf, float af);
void  polyscale(float p[8], float s);
void  polyder(float p[8]);
void  polystretchtime(float p[8], float s);
void  polyreflect(float p[8]);

// Four polynomials of one piece.
struct poly4d poly4d_zero(float duration);
struct poly4d poly4d_linear(float duration, struct vec p0, struct vec p1, float yaw0, float yaw1);
void          poly4d_scale(struct poly4d *p, float x, float y, float z, float yaw);
void          poly4d_shift(struct poly4d *p, float x, float y, float z, float yaw);
void          poly4d_shift_vec(struct poly4d *p, struct vec pos, float yaw);
void          poly4d_stretchtime(struct poly4d *p, float s);
void          polyder4d(struct poly4d *p);
float         poly4d_max_accel_approx(const struct poly4d *p);

// Flat outputs of one piece at t [s].
struct traj_eval poly4d_eval(const struct poly4d *p, float t);
struct traj_eval traj_eval_zero(void);
struct traj_eval traj_eval_invalid(void);
bool             is_traj_eval_valid(const struct traj_eval *ev);
void             traj_eval_transform(struct traj_eval *ev, struct vec shift, float rotation);

// Whole trajectories.
float            piecewise_duration(const struct piecewise_traj *traj);
struct traj_eval piecewise_eval(const struct piecewise_traj *traj, float t);
struct traj_eval piecewise_eval_reversed(const struct piecewise_traj *traj, float t);
bool             piecewise_is_finished(const struct piecewise_traj *traj, float t);

// Plan the one piece that joins two boundary states.
void piecewise_plan_5th_order(struct poly4d *piece, float duration, struct vec p0, float y0,
                              struct vec v0, float dy0, struct vec a0, struct vec p1, float y1,
                              struct vec v1, float dy1, struct vec a1);
void piecewise_plan_7th_order_no_jerk(struct poly4d *piece, float duration, struct vec p0, float y0,
                                      struct vec v0, float dy0, struct vec a0, struct vec p1,
                                      float y1, struct vec v1, float dy1, struct vec a1);

#endif  // PPTRAJ_H
