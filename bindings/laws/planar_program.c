#include "planar_program.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define TOLERANCE 1e-9  // how far a solution may be beyond a half-plane, see planar_program.py
#define PARALLEL 1e-12

typedef struct {
  double x, y;
} point_t;

typedef struct {
  point_t start, along;  // points start + t * along
  double  low, high;     // of t
  bool    is_outside;    // no point of the line satisfies all half-planes
} line_t;

// NaN stays NaN, so that the caller learns of it.
static double limited(double value, double low, double high) {
  return value < low ? low : (value > high ? high : value);
}

// Inserts a half-plane behind those that are as tight, or tighter.
static void insert(cf_half_plane_t *planes, int count, cf_half_plane_t added) {
  int place = count;
  for (; place > 0 && planes[place - 1].side > added.side; place--) {
    planes[place] = planes[place - 1];
  }
  planes[place] = added;
}

// Collects half-planes that cut the square, the tightest first: most neighbors are too far away to
// matter. Returns how many, or -1 where a row of zeros asks for the impossible.
static int collect(int rows, const double *normals, const double *sides, double limit,
                   cf_half_plane_t *planes) {
  int count = 0;
  for (int row = 0; row < rows; row++) {
    const double ax = normals[2 * row], ay = normals[2 * row + 1];
    const double length = hypot(ax, ay);
    if (length == 0.0 && sides[row] < 0.0) {
      return -1;
    }
    const cf_half_plane_t plane = {ax / length, ay / length, sides[row] / length};
    // false for NaN
    if (length > 0.0 && plane.side < limit * (fabs(plane.x) + fabs(plane.y))) {
      insert(planes, count++, plane);
    }
  }
  return count;
}

static void cut(line_t *line, const cf_half_plane_t *plane, double slack) {
  const double slope = plane->x * line->along.x + plane->y * line->along.y;
  const double room  = plane->side - plane->x * line->start.x - plane->y * line->start.y;
  if (slope > PARALLEL) {
    line->high = fmin(line->high, room / slope);
  } else if (slope < -PARALLEL) {
    line->low = fmax(line->low, room / slope);
  } else if (room < -slack) {
    line->is_outside = true;
  }
}

// Finds the nearest point on the boundary of the last half-plane, within the others and the square.
static bool find_on_boundary(const double *desired, const cf_half_plane_t *planes, int last,
                             double limit, double slack, point_t *point) {
  const cf_half_plane_t *border = &planes[last];
  const double           beyond = border->x * desired[0] + border->y * desired[1] - border->side;
  line_t                 line   = {
      .start = {desired[0] - beyond * border->x, desired[1] - beyond * border->y},
      .along = {-border->y, border->x},
      .low   = -INFINITY,
      .high  = INFINITY,
  };
  for (int k = 0; k < last; k++) {
    cut(&line, &planes[k], slack);
  }
  const cf_half_plane_t square[] = {
      {1.0, 0.0, limit}, {-1.0, 0.0, limit}, {0.0, 1.0, limit}, {0.0, -1.0, limit}};
  for (int k = 0; k < 4; k++) {
    cut(&line, &square[k], slack);
  }
  const double place = limited(0.0, line.low, fmax(line.low, line.high));
  point->x           = line.start.x + place * line.along.x;
  point->y           = line.start.y + place * line.along.y;
  return !line.is_outside && line.low <= line.high + slack;
}

static bool solve(const double *desired, const cf_half_plane_t *planes, int count, double limit,
                  point_t *best) {
  const double slack = TOLERANCE * fmax(1.0, limit);
  best->x            = limited(desired[0], -limit, limit);
  best->y            = limited(desired[1], -limit, limit);
  for (int k = 0; k < count; k++) {
    const double beyond = planes[k].x * best->x + planes[k].y * best->y - planes[k].side;
    if (beyond > 0.1 * slack && !find_on_boundary(desired, planes, k, limit, slack, best)) {
      return false;
    }
  }
  return true;
}

void cf_nearest_points(int agents, int rows, const double *desired, const double *normals,
                       const double *sides, const double *limits, cf_half_plane_t *scratch,
                       double *points, uint8_t *found) {
  for (int i = 0; i < agents; i++) {
    const ptrdiff_t first = (ptrdiff_t)i * rows;
    point_t         best  = {NAN, NAN};
    const int       count = collect(rows, normals + 2 * first, sides + first, limits[i], scratch);
    found[i]              = count >= 0 && solve(desired + 2 * i, scratch, count, limits[i], &best);
    points[2 * i]         = found[i] ? best.x : (double)NAN;
    points[2 * i + 1]     = found[i] ? best.y : (double)NAN;
  }
}
