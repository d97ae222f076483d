#include "api/math3d.h"

#define PARALLEL 1e-6f       // sine of the angle below which two vectors count as parallel
#define NEARLY_EQUAL 0.99f   // cosine above which the arc is replaced by the straight line
#define BROKEN_EPSILON 1e9f  // where 1e-9 was meant

struct quat mkquat(float x, float y, float z, float w) {
  return (struct quat){x, y, z, w};
}

struct quat quatvw(struct vec v, float w) {
  return mkquat(v.x, v.y, v.z, w);
}

struct quat qeye(void) {
  return mkquat(0.0f, 0.0f, 0.0f, 1.0f);
}

struct quat qaxisangle(struct vec axis, float angle) {
  const float scale = sinf(angle / 2.0f) / vmag(axis);
  return quatvw(vscl(scale, axis), cosf(angle / 2.0f));
}

struct quat qvectovec(struct vec a_unit, struct vec b_unit) {
  const struct vec cross  = vcross(a_unit, b_unit);
  const float      sine   = vmag(cross);
  const float      cosine = vdot(a_unit, b_unit);
  if (sine < PARALLEL) {
    return cosine > 0.0f ? qeye() : mkquat(0.0f, 0.0f, 0.0f, 0.0f);
  }

  // sine and cosine of half the angle
  const float half_sine   = sqrtf(fmaxf(0.5f - 0.5f * cosine, 0.0f));
  const float half_cosine = sqrtf(fmaxf(0.5f + 0.5f * cosine, 0.0f));
  return quatvw(vscl(half_sine / sine, cross), half_cosine);
}

struct quat rpy2quat(struct vec rpy) {
  const float cr = cosf(rpy.x / 2.0f);
  const float sr = sinf(rpy.x / 2.0f);
  const float cp = cosf(rpy.y / 2.0f);
  const float sp = sinf(rpy.y / 2.0f);
  const float cy = cosf(rpy.z / 2.0f);
  const float sy = sinf(rpy.z / 2.0f);
  return mkquat(sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy);
}

struct quat rpy2quat_small(struct vec rpy) {
  const float n = vmag2(rpy) / 4.0f;
  if (n < 1.0f) {
    return quatvw(vscl(0.5f, rpy), sqrtf(1.0f - n));
  }
  const float w = 1.0f / sqrtf(1.0f + n);
  return quatvw(vscl(w / 2.0f, rpy), w);
}

struct quat mat2quat(struct mat33 m) {
  const float a = m.m[0][0];
  const float b = m.m[1][1];
  const float c = m.m[2][2];
  const float w = sqrtf(fmaxf(0.0f, 1.0f + a + b + c)) / 2.0f;
  const float x = sqrtf(fmaxf(0.0f, 1.0f + a - b - c)) / 2.0f;
  const float y = sqrtf(fmaxf(0.0f, 1.0f - a + b - c)) / 2.0f;
  const float z = sqrtf(fmaxf(0.0f, 1.0f - a - b + c)) / 2.0f;
  return mkquat(copysignf(x, m.m[2][1] - m.m[1][2]), copysignf(y, m.m[0][2] - m.m[2][0]),
                copysignf(z, m.m[1][0] - m.m[0][1]), w);
}

// ------------------------------------------------------------------------------------- conversion

struct vec quat2rpy(struct quat q) {
  return mkvec(atan2f(2.0f * (q.w * q.x + q.y * q.z), 1.0f - 2.0f * (fsqr(q.x) + fsqr(q.y))),
               asinf(2.0f * (q.w * q.y - q.x * q.z)),
               atan2f(2.0f * (q.w * q.z + q.x * q.y), 1.0f - 2.0f * (fsqr(q.y) + fsqr(q.z))));
}

struct vec quat2axis(struct quat q) {
  return vscl(1.0f / sqrtf(1.0f - q.w * q.w), quatimagpart(q));
}

float quat2angle(struct quat q) {
  const float angle = 2.0f * acosf(q.w);
  return angle > M_PI_F ? angle - 2.0f * M_PI_F : angle;
}

struct vec quatimagpart(struct quat q) {
  return mkvec(q.x, q.y, q.z);
}

struct mat33 quat2rotmat(struct quat q) {
  const float x = q.x;
  const float y = q.y;
  const float z = q.z;
  const float w = q.w;
  return mrows(mkvec(1.0f - 2.0f * y * y - 2.0f * z * z, 2.0f * x * y - 2.0f * z * w,
                     2.0f * x * z + 2.0f * y * w),
               mkvec(2.0f * x * y + 2.0f * z * w, 1.0f - 2.0f * x * x - 2.0f * z * z,
                     2.0f * y * z - 2.0f * x * w),
               mkvec(2.0f * x * z - 2.0f * y * w, 2.0f * y * z + 2.0f * x * w,
                     1.0f - 2.0f * x * x - 2.0f * y * y));
}

// -------------------------------------------------------------------------------------- operators

// 2 (u.v) u + (w^2 - u.u) v + 2 w (u x v), with u the vector part
struct vec qvrot(struct quat q, struct vec v) {
  const struct vec u = quatimagpart(q);
  return vadd3(vscl(2.0f * vdot(u, v), u), vscl(q.w * q.w - vdot(u, u), v),
               vscl(2.0f * q.w, vcross(u, v)));
}

// Hamilton's product, as since release 2026.08; terms in the order of the one before
struct quat qqmul(struct quat q, struct quat p) {
  return mkquat(q.w * p.x - q.z * p.y + q.y * p.z + q.x * p.w,
                q.z * p.x + q.w * p.y - q.x * p.z + q.y * p.w,
                -q.y * p.x + q.x * p.y + q.w * p.z + q.z * p.w,
                -q.x * p.x - q.y * p.y - q.z * p.z + q.w * p.w);
}

struct quat qinv(struct quat q) {
  return mkquat(-q.x, -q.y, -q.z, q.w);
}

struct quat qneg(struct quat q) {
  return mkquat(-q.x, -q.y, -q.z, -q.w);
}

struct quat qposreal(struct quat q) {
  return q.w < 0.0f ? qneg(q) : q;
}

float qdot(struct quat a, struct quat b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

bool qeq(struct quat a, struct quat b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w;
}

static struct quat qscl(float s, struct quat q) {
  return mkquat(s * q.x, s * q.y, s * q.z, s * q.w);
}

struct quat qnormalize(struct quat q) {
  return qscl(1.0f / sqrtf(qdot(q, q)), q);
}

float qanglebetween(struct quat a, struct quat b) {
  const float cosine = qdot(qposreal(a), qposreal(b));
  return cosine > 1.0f - BROKEN_EPSILON ? 0.0f : acosf(cosine);
}

struct quat quat_gyro_update(struct quat q, struct vec gyro, float dt) {
  const float r = (dt / 2.0f) * gyro.x;
  const float p = (dt / 2.0f) * gyro.y;
  const float y = (dt / 2.0f) * gyro.z;
  return mkquat(q.x + y * q.y - p * q.z + r * q.w, -y * q.x + q.y + r * q.z + p * q.w,
                p * q.x - r * q.y + q.z + y * q.w, -r * q.x - p * q.y - y * q.z + q.w);
}

// ---------------------------------------------------------------------------------- interpolation

static struct quat weighted(float weight_a, struct quat a, float weight_b, struct quat b) {
  return mkquat(weight_a * a.x + weight_b * b.x, weight_a * a.y + weight_b * b.y,
                weight_a * a.z + weight_b * b.z, weight_a * a.w + weight_b * b.w);
}

struct quat qnlerp(struct quat a, struct quat b, float t) {
  return qnormalize(weighted(1.0f - t, a, t, b));
}

struct quat qslerp(struct quat a, struct quat b, float t) {
  // of b and -b, which are the same attitude, the nearer one
  float cosine = qdot(a, b);
  if (cosine < 0.0f) {
    cosine = -cosine;
    b      = qneg(b);
  }
  if (cosine > NEARLY_EQUAL) {
    return qnlerp(a, b, t);
  }

  const float angle = acosf(cosine);
  const float sine  = sinf(angle);
  return weighted(sinf(angle * (1.0f - t)) / sine, a, sinf(angle * t) / sine, b);
}

// ------------------------------------------------------------------------------------ in and out

struct quat qload(const double *d) {
  return mkquat((float)d[0], (float)d[1], (float)d[2], (float)d[3]);
}

void qstore(struct quat q, double *d) {
  vstore(quatimagpart(q), d);
  d[3] = (double)q.w;
}

struct quat qloadf(const float *f) {
  return mkquat(f[0], f[1], f[2], f[3]);
}

void qstoref(struct quat q, float *f) {
  vstoref(quatimagpart(q), f);
  f[3] = q.w;
}
