#include "flatness.h"

#include <math.h>
#include <stddef.h>

#include "rotation.h"

#define TINY 1e-300  // keeps a force that points straight up from dividing by zero

typedef struct {
  double x[3], y[3], z[3];
  double ahead;   // how much z leans ahead
  double length;  // of z x heading
} axes_t;

// Limits a force; NaN stays NaN, so that the caller learns of it.
static void limit(double force[3], double least_lift, double max_slope) {
  if (force[2] < least_lift) {
    force[2] = least_lift;
  }
  const double aside = hypot(force[0], force[1]), widest = force[2] * max_slope;
  if (aside > widest) {
    const double share = widest / fmax(aside, TINY);
    force[0] *= share;
    force[1] *= share;
  }
}

// Finds the axes: in the frame of the heading y is (0, level, -side / length). z always points up a
// little, so that the length is not 0.
static void find_axes(const double force[3], double size, double yaw, axes_t *axes) {
  const double c = cos(yaw), s = sin(yaw);
  for (int i = 0; i < 3; i++) {
    axes->z[i] = force[i] / size;
  }
  const double *z     = axes->z;
  const double  side  = z[1] * c - z[0] * s;
  axes->ahead         = z[0] * c + z[1] * s;
  axes->length        = hypot(z[2], side);
  const double level  = z[2] / axes->length;
  axes->y[2]          = -side / axes->length;
  axes->y[0]          = -level * s;
  axes->y[1]          = level * c;
  const double beside = axes->y[2] * axes->ahead;
  axes->x[0]          = axes->length * c - beside * s;
  axes->x[1]          = axes->length * s + beside * c;
  axes->x[2]          = level * -axes->ahead;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void find_rates(const axes_t *axes, double size, const double *push, double yaw_rate,
                       double rates[3]) {
  rates[0] = push == NULL ? 0.0 : -(dot(axes->y, push) / size);
  rates[1] = push == NULL ? 0.0 : dot(axes->x, push) / size;
  rates[2] = rates[0] * (axes->ahead / axes->length) +
             yaw_rate * (axes->z[2] / axes->length / axes->length);
}

void cf_flatness(int count, const cf_flatness_t *wanted, double *thrusts, double *rotations,
                 double *rates) {
  for (int i = 0; i < count; i++) {
    const ptrdiff_t of_three = 3 * (ptrdiff_t)i;
    const double   *given    = wanted->forces + of_three;
    const double    yaw      = wanted->yaws == NULL ? 0.0 : wanted->yaws[i];
    const double    yaw_rate = wanted->yaw_rates == NULL ? 0.0 : wanted->yaw_rates[i];
    const double   *push     = wanted->pushes == NULL ? NULL : wanted->pushes + of_three;
    double          force[3] = {given[0], given[1], given[2]};
    limit(force, wanted->least_lifts[i], wanted->max_slope);
    const double size = sqrt(dot(force, force));
    axes_t       axes;
    find_axes(force, size, yaw, &axes);
    double present[9];
    cf_rotation_of(wanted->attitudes + 4 * (ptrdiff_t)i, present);
    const double up[3]  = {present[2], present[5], present[8]};
    const double thrust = dot(force, up);
    thrusts[i]          = thrust < 0.0 ? 0.0 : thrust;
    for (int k = 0; k < 3; k++) {
      double *row = rotations + 9 * (ptrdiff_t)i + 3 * (ptrdiff_t)k;
      row[0]      = axes.x[k];
      row[1]      = axes.y[k];
      row[2]      = axes.z[k];
    }
    find_rates(&axes, size, push, yaw_rate, rates + of_three);
  }
}
