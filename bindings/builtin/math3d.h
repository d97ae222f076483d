/* Vectors and 3x3 matrices by value, with the names and the rounding of the firmware's math3d.h.
 *
 * Internal to C: Python reads api/math3d.h. Source: planner-commander dossier section 3. */
#ifndef CF_BUILTIN_MATH3D_H
#define CF_BUILTIN_MATH3D_H

#include <math.h>
#include <stdbool.h>

#include "api/math3d.h"
#include "api/vec.h"

#define M_PI_F 3.14159265358979323846f

struct mat33 {
  float m[3][3];  // [row][column]
};

static inline float radians(float degrees_) {
  return (M_PI_F / 180.0f) * degrees_;
}

static inline float degrees(float radians_) {
  return (180.0f / M_PI_F) * radians_;
}

static inline struct vec mkvec(float x, float y, float z) {
  return (struct vec){x, y, z};
}

static inline struct vec vzero(void) {
  return mkvec(0.0f, 0.0f, 0.0f);
}

static inline struct vec vadd(struct vec a, struct vec b) {
  return mkvec(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline struct vec vneg(struct vec v) {
  return mkvec(-v.x, -v.y, -v.z);
}

static inline struct vec vsub(struct vec a, struct vec b) {
  return vadd(a, vneg(b));
}

static inline struct vec vscl(float s, struct vec v) {
  return mkvec(s * v.x, s * v.y, s * v.z);
}

// one reciprocal, then products: not three divisions
static inline struct vec vdiv(struct vec v, float s) {
  return vscl(1.0f / s, v);
}

static inline float vdot(struct vec a, struct vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float vmag(struct vec v) {
  return sqrtf(vdot(v, v));
}

// NaN for the zero vector
static inline struct vec vnormalize(struct vec v) {
  return vdiv(v, vmag(v));
}

static inline struct vec vcross(struct vec a, struct vec b) {
  return mkvec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// The part of a that is orthogonal to a unit vector.
static inline struct vec vorthunit(struct vec a, struct vec unit) {
  return vsub(a, vscl(vdot(a, unit), unit));
}

static inline float vnorm1(struct vec v) {
  return fabsf(v.x) + fabsf(v.y) + fabsf(v.z);
}

static inline struct vec vclampnorm(struct vec v, float max) {
  const float norm = vmag(v);
  return norm > max ? vscl(max / norm, v) : v;
}

static inline struct vec veltrecip(struct vec v) {
  return mkvec(1.0f / v.x, 1.0f / v.y, 1.0f / v.z);
}

static inline struct vec veltmul(struct vec a, struct vec b) {
  return mkvec(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline bool visnan(struct vec v) {
  return isnan(v.x) || isnan(v.y) || isnan(v.z);
}

static inline struct vec mvmul(struct mat33 a, struct vec v) {
  return mkvec(a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
               a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
               a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z);
}

// Rotation about z. I + sin K + (1 - cos) K^2 rounds the diagonal: it is not cos itself.
static inline struct mat33 mrotz(float angle) {
  const float s = sinf(angle);
  const float c = 1.0f + (1.0f - cosf(angle)) * -1.0f;
  return (struct mat33){{{c, -s, 0.0f}, {s, c, 0.0f}, {0.0f, 0.0f, 1.0f}}};
}

#endif  // CF_BUILTIN_MATH3D_H
