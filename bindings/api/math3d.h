/* Small vectors, matrices and quaternions by value, with the names and the rounding of the
 * firmware's math3d.h (docs/reference/control-geometric.md#4,
 * docs/reference/planner-commander.md#3).
 *
 * Upstream's header is made of inline functions; these are ordinary ones, so that Python can call
 * them, and the link-time optimizer puts them where they are used. Nothing is guarded: what
 * upstream divides by zero is infinite or NaN here too. Matrices are m[row][column]. Quaternions
 * have the scalar last, are unit unless said otherwise and turn body vectors into the world. Euler
 * angles are roll, pitch, yaw [rad] with R = Rz(yaw) Ry(pitch) Rx(roll), all right-handed: the
 * pitch of state_t and setpoint_t has the other sign. */
#ifndef MATH3D_H
#define MATH3D_H

#include <math.h>
#include <stdbool.h>

#include "api/vec.h"

#define M_PI_F 3.14159265358979323846f
#define M_1_PI_F 0.31830988618379067154f
#define M_PI_2_F 1.57079632679f

struct mat33 {
  float m[3][3];  // [row][column]
};

struct quat {
  float x;
  float y;
  float z;
  float w;
};

// ---------------------------------------------------------------------------------------- scalars

float fsqr(float x);
float radians(float degrees);
float degrees(float radians);

// Limits a value to [min, max]; NaN passes through.
float clamp(float value, float min, float max);

// Returns whether a and b are at most `ulps` floats apart. Numbers of different sign are only close
// when they are equal.
bool fcloseulps(float a, float b, int ulps);

// Returns the angle [rad] wrapped to [-pi, pi]. Not exact for small angles: pi is added and taken
// away again in float32, so normalize_radians(0.2) is 0.200000048.
float normalize_radians(float radians);

// Returns the signed turn [rad] that leads from start to goal the short way round.
float shortest_signed_angle_radians(float start, float goal);

// ---------------------------------------------------------------------------------------- vectors

struct vec mkvec(float x, float y, float z);
struct vec vrepeat(float x);
struct vec vzero(void);
struct vec vbasis(int i);  // unit vector of axis 0, 1 or 2

struct vec vscl(float s, struct vec v);
struct vec vneg(struct vec v);
struct vec vdiv(struct vec v, float s);  // one reciprocal, then products
struct vec vadd(struct vec a, struct vec b);
struct vec vsub(struct vec a, struct vec b);
struct vec vadd3(struct vec a, struct vec b, struct vec c);                // (a + b) + c
struct vec vadd4(struct vec a, struct vec b, struct vec c, struct vec d);  // (a + b) + (c + d)
struct vec vsub2(struct vec a, struct vec b, struct vec c);                // (a - b) - c

float      vdot(struct vec a, struct vec b);
struct vec vcross(struct vec a, struct vec b);
float      vmag2(struct vec v);
float      vmag(struct vec v);
float      vdist2(struct vec a, struct vec b);
float      vdist(struct vec a, struct vec b);
struct vec vnormalize(struct vec v);  // NaN for the zero vector; may come out an ulp short
struct vec vclampnorm(struct vec v, float max);
struct vec vprojectunit(struct vec a, struct vec b_unit);  // the part of a along a unit vector
struct vec vorthunit(struct vec a, struct vec b_unit);     // the part orthogonal to it

// element by element
struct vec veltmul(struct vec a, struct vec b);
struct vec veltdiv(struct vec a, struct vec b);
struct vec veltrecip(struct vec a);
struct vec vabs(struct vec v);
struct vec vmin(struct vec a, struct vec b);
struct vec vmax(struct vec a, struct vec b);
struct vec vclamp(struct vec v, struct vec lower, struct vec upper);
struct vec vclampabs(struct vec v, struct vec abs_upper);

// over the elements
float vmaxelt(struct vec v);
float vminelt(struct vec v);
float vnorm1(struct vec v);

// comparisons hold when they hold for all elements; visnan when any is NaN
bool veq(struct vec a, struct vec b);
bool vneq(struct vec a, struct vec b);  // not veq
bool veqepsilon(struct vec a, struct vec b, float epsilon);
bool vless(struct vec a, struct vec b);
bool vleq(struct vec a, struct vec b);
bool vgreater(struct vec a, struct vec b);
bool vgeq(struct vec a, struct vec b);
bool visnan(struct vec v);

struct vec vload(const double *d);
void       vstore(struct vec v, double *d);
struct vec vloadf(const float *f);
void       vstoref(struct vec v, float *f);
float      vindex(struct vec v, int i);

// --------------------------------------------------------------------------------------- matrices

struct mat33 mzero(void);
struct mat33 mdiag(float a, float b, float c);
struct mat33 meyescl(float a);
struct mat33 meye(void);
struct mat33 mcolumns(struct vec a, struct vec b, struct vec c);
struct mat33 mrows(struct vec a, struct vec b, struct vec c);
struct mat33 mcrossmat(struct vec v);  // its product with x is v cross x
struct vec   mcolumn(struct mat33 m, int column);
struct vec   mrow(struct mat33 m, int row);

struct mat33 mtranspose(struct mat33 m);
struct mat33 mscl(float s, struct mat33 a);
struct mat33 mneg(struct mat33 a);
struct mat33 madd(struct mat33 a, struct mat33 b);
struct mat33 msub(struct mat33 a, struct mat33 b);
struct mat33 madd3(struct mat33 a, struct mat33 b, struct mat33 c);
struct mat33 maddridge(struct mat33 a, float d);  // a + d I
struct vec   mvmul(struct mat33 a, struct vec v);
struct mat33 mmul(struct mat33 a, struct mat33 b);
bool         misnan(struct mat33 m);

// Writes a 3x3 block of a larger row-major matrix; `stride` is the length of one of its rows.
void set_block33_rowmaj(float *block, int stride, const struct mat33 *m);

// Rotations. The diagonal comes from I + sin K + (1 - cos) K^2 and is rounded there: not cos
// itself.
struct mat33 maxisangle(struct vec axis_unit, float angle);
struct mat33 mrotx(float angle);
struct mat33 mroty(float angle);
struct mat33 mrotz(float angle);

// ------------------------------------------------------------------------------------ quaternions

struct quat mkquat(float x, float y, float z, float w);
struct quat quatvw(struct vec v, float w);
struct quat qeye(void);
struct quat qaxisangle(struct vec axis, float angle);
struct quat qvectovec(struct vec a_unit, struct vec b_unit);  // all zero for opposite vectors
struct quat rpy2quat(struct vec rpy);
struct quat rpy2quat_small(struct vec rpy);  // to first order
struct quat mat2quat(struct mat33 m);        // poor near half a turn

struct vec   quat2rpy(struct quat q);
struct vec   quat2axis(struct quat q);
float        quat2angle(struct quat q);  // in (-pi, pi]
struct vec   quatimagpart(struct quat q);
struct mat33 quat2rotmat(struct quat q);  // identity for the zero quaternion

struct vec  qvrot(struct quat q, struct vec v);
struct quat qqmul(struct quat q, struct quat p);  // turns by p first: qvrot(q, qvrot(p, v))
struct quat qinv(struct quat q);
struct quat qneg(struct quat q);
struct quat qposreal(struct quat q);  // the one of q and -q whose w is not negative
float       qdot(struct quat a, struct quat b);
bool        qeq(struct quat a, struct quat b);
struct quat qnormalize(struct quat q);

// 0 for any two quaternions, as in the firmware: its guard against rounding lets nothing through.
float qanglebetween(struct quat a, struct quat b);

// Turns q by body rates [rad/s] for dt [s], to first order; the result is not normalized.
struct quat quat_gyro_update(struct quat q, struct vec gyro, float dt);

// From a (t = 0) to b (t = 1): the straight line normalized, and the arc with constant speed.
struct quat qnlerp(struct quat a, struct quat b, float t);
struct quat qslerp(struct quat a, struct quat b, float t);

// in the order x, y, z, w
struct quat qload(const double *d);
void        qstore(struct quat q, double *d);
struct quat qloadf(const float *f);
void        qstoref(struct quat q, float *f);

// ------------------------------------------------------------------------------------ convex sets

// A polytope is the set of x with A x <= b: n rows of A, unit and one after the other, and n
// numbers.

// Returns the point with a_unit . x <= b that is closest to x.
struct vec vprojecthalfspace(struct vec x, struct vec a_unit, float b);

// Returns whether v violates no row by more than `tolerance`.
bool vinpolytope(struct vec v, const float A[], const float b[], int n, float tolerance);

// Returns how many directions one can go from the origin, which must be inside, and the first row
// that is hit; INFINITY and row -1 if there is none. `active_row` may be null.
float rayintersectpolytope(struct vec origin, struct vec direction, const float A[],
                           const float b[], int n, int *active_row);

// Returns nearly the point of the polytope that is closest to v, by Dykstra's alternating
// projections; it may miss the polytope by about `tolerance`, and by more if `maxiters` sweeps did
// not suffice. `work` has room for 3 n floats.
struct vec vprojectpolytope(struct vec v, const float A[], const float b[], float work[], int n,
                            float tolerance, int maxiters);

#endif  // MATH3D_H
