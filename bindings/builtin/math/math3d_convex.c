#include "api/math3d.h"

#include <stddef.h>

struct vec vprojecthalfspace(struct vec x, struct vec a_unit, float b) {
  const float along = vdot(a_unit, x);
  return along <= b ? x : vadd(x, vscl(b - along, a_unit));
}

bool vinpolytope(struct vec v, const float A[], const float b[], int n, float tolerance) {
  for (int i = 0; i < n; i++) {
    // negated, so that a row of NaN has nothing inside
    if (!(vdot(vloadf(A + 3 * i), v) <= b[i] + tolerance)) {
      return false;
    }
  }
  return true;
}

float rayintersectpolytope(struct vec origin, struct vec direction, const float A[],
                           const float b[], int n, int *active_row) {
  float nearest = INFINITY;
  int   row     = -1;
  for (int i = 0; i < n; i++) {
    const struct vec a        = vloadf(A + 3 * i);
    const float      approach = vdot(a, direction);
    if (approach <= 0.0f) {
      continue;  // moves along this wall or away from it
    }
    const float distance = (b[i] - vdot(a, origin)) / approach;
    if (distance < nearest) {
      nearest = distance;
      row     = i;
    }
  }
  if (active_row != NULL) {
    *active_row = row;
  }
  return nearest;
}

struct vec vprojectpolytope(struct vec v, const float A[], const float b[], float work[], int n,
                            float tolerance, int maxiters) {
  if (vinpolytope(v, A, b, n, tolerance)) {
    return v;
  }

  // z: what each half-space has moved the point by, taken back before it is asked again
  float *z = work;
  for (int i = 0; i < 3 * n; i++) {
    z[i] = 0.0f;
  }

  const float small = (float)n * fsqr(tolerance) / 10.0f;
  struct vec  x     = v;
  for (int sweep = 0; sweep < maxiters; sweep++) {
    float change = 0.0f;
    for (int i = 0; i < n; i++) {
      const struct vec x_old = x;
      const struct vec z_old = vloadf(z + 3 * i);
      x                      = vprojecthalfspace(vsub(x_old, z_old), vloadf(A + 3 * i), b[i]);
      const struct vec z_new = vadd(vsub(x, x_old), z_old);
      vstoref(z_new, z + 3 * i);
      change += vdist2(z_old, z_new);
    }
    if (change < small) {
      break;
    }
  }
  return x;
}
