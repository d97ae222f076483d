#include "api/math3d.h"

struct vec mkvec(float x, float y, float z) {
  return (struct vec){x, y, z};
}

struct vec vrepeat(float x) {
  return mkvec(x, x, x);
}

struct vec vzero(void) {
  return vrepeat(0.0f);
}

struct vec vbasis(int i) {
  return mkvec(i == 0 ? 1.0f : 0.0f, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f);
}

// ------------------------------------------------------------------------------------- arithmetic

struct vec vscl(float s, struct vec v) {
  return mkvec(s * v.x, s * v.y, s * v.z);
}

struct vec vneg(struct vec v) {
  return mkvec(-v.x, -v.y, -v.z);
}

struct vec vdiv(struct vec v, float s) {
  return vscl(1.0f / s, v);
}

struct vec vadd(struct vec a, struct vec b) {
  return mkvec(a.x + b.x, a.y + b.y, a.z + b.z);
}

struct vec vsub(struct vec a, struct vec b) {
  return vadd(a, vneg(b));
}

struct vec vadd3(struct vec a, struct vec b, struct vec c) {
  return vadd(vadd(a, b), c);
}

struct vec vadd4(struct vec a, struct vec b, struct vec c, struct vec d) {
  return vadd(vadd(a, b), vadd(c, d));
}

struct vec vsub2(struct vec a, struct vec b, struct vec c) {
  return vsub(vsub(a, b), c);
}

// --------------------------------------------------------------------------- lengths and angles

float vdot(struct vec a, struct vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

struct vec vcross(struct vec a, struct vec b) {
  return mkvec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

float vmag2(struct vec v) {
  return vdot(v, v);
}

float vmag(struct vec v) {
  return sqrtf(vmag2(v));
}

float vdist2(struct vec a, struct vec b) {
  return vmag2(vsub(a, b));
}

float vdist(struct vec a, struct vec b) {
  return sqrtf(vdist2(a, b));
}

struct vec vnormalize(struct vec v) {
  return vdiv(v, vmag(v));
}

struct vec vclampnorm(struct vec v, float max) {
  const float norm = vmag(v);
  return norm > max ? vscl(max / norm, v) : v;
}

struct vec vprojectunit(struct vec a, struct vec b_unit) {
  return vscl(vdot(a, b_unit), b_unit);
}

struct vec vorthunit(struct vec a, struct vec b_unit) {
  return vsub(a, vprojectunit(a, b_unit));
}

// ----------------------------------------------------------------------------- element by element

struct vec veltmul(struct vec a, struct vec b) {
  return mkvec(a.x * b.x, a.y * b.y, a.z * b.z);
}

struct vec veltdiv(struct vec a, struct vec b) {
  return mkvec(a.x / b.x, a.y / b.y, a.z / b.z);
}

struct vec veltrecip(struct vec a) {
  return mkvec(1.0f / a.x, 1.0f / a.y, 1.0f / a.z);
}

struct vec vabs(struct vec v) {
  return mkvec(fabsf(v.x), fabsf(v.y), fabsf(v.z));
}

struct vec vmin(struct vec a, struct vec b) {
  return mkvec(fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z));
}

struct vec vmax(struct vec a, struct vec b) {
  return mkvec(fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z));
}

struct vec vclamp(struct vec v, struct vec lower, struct vec upper) {
  return vmin(upper, vmax(v, lower));
}

struct vec vclampabs(struct vec v, struct vec abs_upper) {
  return vclamp(v, vneg(abs_upper), abs_upper);
}

float vmaxelt(struct vec v) {
  return fmaxf(fmaxf(v.x, v.y), v.z);
}

float vminelt(struct vec v) {
  return fminf(fminf(v.x, v.y), v.z);
}

float vnorm1(struct vec v) {
  return fabsf(v.x) + fabsf(v.y) + fabsf(v.z);
}

// ------------------------------------------------------------------------------------ comparisons

bool veq(struct vec a, struct vec b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

bool vneq(struct vec a, struct vec b) {
  return !veq(a, b);
}

bool veqepsilon(struct vec a, struct vec b, float epsilon) {
  return vless(vabs(vsub(a, b)), vrepeat(epsilon));
}

bool vless(struct vec a, struct vec b) {
  return a.x < b.x && a.y < b.y && a.z < b.z;
}

bool vleq(struct vec a, struct vec b) {
  return a.x <= b.x && a.y <= b.y && a.z <= b.z;
}

bool vgreater(struct vec a, struct vec b) {
  return vless(b, a);
}

bool vgeq(struct vec a, struct vec b) {
  return vleq(b, a);
}

bool visnan(struct vec v) {
  return isnan(v.x) || isnan(v.y) || isnan(v.z);
}

// ------------------------------------------------------------------------------------ in and out

struct vec vload(const double *d) {
  return mkvec((float)d[0], (float)d[1], (float)d[2]);
}

void vstore(struct vec v, double *d) {
  d[0] = (double)v.x;
  d[1] = (double)v.y;
  d[2] = (double)v.z;
}

struct vec vloadf(const float *f) {
  return mkvec(f[0], f[1], f[2]);
}

void vstoref(struct vec v, float *f) {
  f[0] = v.x;
  f[1] = v.y;
  f[2] = v.z;
}

float vindex(struct vec v, int i) {
  const float elements[3] = {v.x, v.y, v.z};
  return elements[i];
}
