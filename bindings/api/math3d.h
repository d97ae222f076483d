/* Angles, with the names of the firmware's math3d.h (planner-commander dossier section 3).
 *
 * The vector helpers of that header are inline and live in builtin/math3d.h. */
#ifndef MATH3D_H
#define MATH3D_H

// Returns the angle [rad] wrapped to [-pi, pi]. Not exact for small angles: pi is added and taken
// away again in float32, so normalize_radians(0.2) is 0.200000048.
float normalize_radians(float radians);

// Returns the signed turn [rad] that leads from start to goal the short way round.
float shortest_signed_angle_radians(float start, float goal);

#endif  // MATH3D_H
