/* From a force to the thrust and the attitude that make it, for the flatness laws of
 * crazychoir_fw.control (docs/reference/crazychoir.md#4.3; Mellinger and Kumar 2011). */
#ifndef CF_LAWS_FLATNESS_H
#define CF_LAWS_FLATNESS_H

typedef struct {
  const double *forces;       // that the rotors are to make [N, world], (count, 3)
  const double *attitudes;    // present quaternions x, y, z, w, of any length, (count, 4)
  const double *least_lifts;  // least upward force [N], (count)
  double        max_slope;    // largest tangent of the tilt, or infinity
  const double *yaws;         // [rad], (count), or NULL: all are 0
  const double *pushes;       // change of the forces, mass times jerk [N/s], (count, 3), or NULL
  const double *yaw_rates;    // [rad/s], (count), or NULL: all are 0
} cf_flatness_t;

// Writes thrusts [N] (count), wanted attitudes, rotation matrices from body to world
// (count, 3, 3), and the body rates [rad/s] at which these turn (count, 3).
//
// Forces are limited first: they point up by the least lift, and aside by the slope. With z along
// the force, y lies in the plane that is level across the heading, and x = y x z. Thrust is the
// share of the force along the present z. F' = push makes p = -y.F'/|F| and q = x.F'/|F|; r is what
// keeps y level.
void cf_flatness(int count, const cf_flatness_t *wanted, double *thrusts, double *rotations,
                 double *rates);

#endif  // CF_LAWS_FLATNESS_H
