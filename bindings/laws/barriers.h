/* Barriers between agents that follow accelerations, and the accelerations that keep them, for the
 * safety filters of crazychoir_fw.control (docs/reference/crazychoir.md#9). */
#ifndef CF_LAWS_BARRIERS_H
#define CF_LAWS_BARRIERS_H

// Writes the motion of agents relative to those near each, in the horizontal plane: own position
// minus the other's [m] and the same of velocities [m/s], both (agents, near, 2). Positions and
// velocities are (agents, axes) and (agents, near, axes), with two axes or more. An agent whose
// position is NaN is at infinity, and one whose velocity is NaN is at rest relative to the own one.
void cf_relative_motion(int agents, int near, int axes, const double *own_positions,
                        const double *own_velocities, const double *positions,
                        const double *velocities, double *offsets, double *closings);

typedef struct {
  double distance;  // [m], least one
  double gamma;     // [s/m^2], how fast a barrier may fall
  double braking;   // [m/s^2], that the barrier counts on: 2 a kappa
  double slowing;   // factor of the last term of the sides; 1 makes them the derivative of h
} cf_acceleration_barrier_t;

// Writes the half-planes normal . u <= side of accelerations that are safe [m/s^2], normals
// (count, 2) of length 1, and the barriers h [m/s]: with D = |dp| - distance,
//
//   h = dp.dv / |dp| + sqrt(braking D)
//   side = (gamma h^3 + (|dv|^2 - (dp.dv / |dp|)^2) / |dp| + slowing braking (dp.dv / |dp|)
//           / (2 sqrt(braking D))) / 2
//
// Within the distance the side is 0: no acceleration towards the other. At infinity there is no
// half-plane: the normal is 0, side and barrier are infinite.
void cf_acceleration_barriers(int count, const double *offsets, const double *closings,
                              const cf_acceleration_barrier_t *barrier, double *normals,
                              double *sides, double *barriers);

#endif  // CF_LAWS_BARRIERS_H
