/* The nearest point of the plane within half-planes and a square, for the safety filters of
 * crazychoir_fw.control.
 *
 * Minimize |u - u_desired|^2 where A u <= b and |u|_max <= limit. Half-planes are added one by one,
 * the tightest first: where the best point so far violates the next one, the new best point lies on
 * its boundary, which leaves a program of one variable in closed form (Seidel 1991). */
#ifndef CF_LAWS_PLANAR_PROGRAM_H
#define CF_LAWS_PLANAR_PROGRAM_H

#include <stdint.h>

typedef struct {
  double x, y;  // normal of length 1
  double side;  // x * ux + y * uy <= side
} cf_half_plane_t;

// Solves one program per agent. `normals` (agents, rows, 2) may have any length; a row of zeros is
// no half-plane, and has no solution if its side is negative. `scratch` holds `rows` half-planes.
// Where there is no solution, `found` is 0 and the point is NaN.
void cf_nearest_points(int agents, int rows, const double *desired, const double *normals,
                       const double *sides, const double *limits, cf_half_plane_t *scratch,
                       double *points, uint8_t *found);

#endif  // CF_LAWS_PLANAR_PROGRAM_H
