#include "api/math3d.h"

struct mat33 mzero(void) {
  return (struct mat33){{{0.0f}}};
}

struct mat33 mdiag(float a, float b, float c) {
  return (struct mat33){{{a, 0.0f, 0.0f}, {0.0f, b, 0.0f}, {0.0f, 0.0f, c}}};
}

struct mat33 meyescl(float a) {
  return mdiag(a, a, a);
}

struct mat33 meye(void) {
  return meyescl(1.0f);
}

struct mat33 mcolumns(struct vec a, struct vec b, struct vec c) {
  return (struct mat33){{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}};
}

struct mat33 mrows(struct vec a, struct vec b, struct vec c) {
  return (struct mat33){{{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}}};
}

struct mat33 mcrossmat(struct vec v) {
  return (struct mat33){{{0.0f, -v.z, v.y}, {v.z, 0.0f, -v.x}, {-v.y, v.x, 0.0f}}};
}

struct vec mcolumn(struct mat33 m, int column) {
  return mkvec(m.m[0][column], m.m[1][column], m.m[2][column]);
}

struct vec mrow(struct mat33 m, int row) {
  return vloadf(m.m[row]);
}

// ------------------------------------------------------------------------------------- arithmetic

struct mat33 mtranspose(struct mat33 m) {
  return mcolumns(mrow(m, 0), mrow(m, 1), mrow(m, 2));
}

struct mat33 mscl(float s, struct mat33 a) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      a.m[i][j] *= s;
    }
  }
  return a;
}

struct mat33 mneg(struct mat33 a) {
  return mscl(-1.0f, a);
}

struct mat33 madd(struct mat33 a, struct mat33 b) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      a.m[i][j] += b.m[i][j];
    }
  }
  return a;
}

struct mat33 msub(struct mat33 a, struct mat33 b) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      a.m[i][j] -= b.m[i][j];
    }
  }
  return a;
}

struct mat33 madd3(struct mat33 a, struct mat33 b, struct mat33 c) {
  return madd(madd(a, b), c);
}

struct mat33 maddridge(struct mat33 a, float d) {
  for (int i = 0; i < 3; i++) {
    a.m[i][i] += d;
  }
  return a;
}

struct vec mvmul(struct mat33 a, struct vec v) {
  return mkvec(vdot(mrow(a, 0), v), vdot(mrow(a, 1), v), vdot(mrow(a, 2), v));
}

struct mat33 mmul(struct mat33 a, struct mat33 b) {
  struct mat33 product = mzero();
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      for (int k = 0; k < 3; k++) {
        product.m[i][j] += a.m[i][k] * b.m[k][j];
      }
    }
  }
  return product;
}

bool misnan(struct mat33 m) {
  return visnan(mrow(m, 0)) || visnan(mrow(m, 1)) || visnan(mrow(m, 2));
}

void set_block33_rowmaj(float *block, int stride, const struct mat33 *m) {
  for (int i = 0; i < 3; i++) {
    vstoref(mrow(*m, i), block + i * stride);
  }
}

// -------------------------------------------------------------------------------------- rotations

struct mat33 maxisangle(struct vec axis_unit, float angle) {
  const struct mat33 k = mcrossmat(axis_unit);
  return madd3(meye(), mscl(sinf(angle), k), mscl(1.0f - cosf(angle), mmul(k, k)));
}

struct mat33 mrotx(float angle) {
  return maxisangle(vbasis(0), angle);
}

struct mat33 mroty(float angle) {
  return maxisangle(vbasis(1), angle);
}

// the same numbers as maxisangle, without its products with zero: plans are rotated with it
struct mat33 mrotz(float angle) {
  const float s = sinf(angle);
  const float c = 1.0f + (1.0f - cosf(angle)) * -1.0f;
  return (struct mat33){{{c, -s, 0.0f}, {s, c, 0.0f}, {0.0f, 0.0f, 1.0f}}};
}
