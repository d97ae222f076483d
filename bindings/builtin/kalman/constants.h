/* Numbers that the parts of the filter share (docs/reference/estimators.md#2). Internal to C. */
#ifndef CF_BUILTIN_KALMAN_CONSTANTS_H
#define CF_BUILTIN_KALMAN_CONSTANTS_H

#define GRAVITY_MAGNITUDE 9.81f  // [m/s^2]

#define PI 3.14159265358979f
#define DEG_TO_RAD (PI / 180.0f)
#define RAD_TO_DEG (180.0f / PI)

#define MAX_COVARIANCE 100.0f
#define MIN_COVARIANCE 1e-6f

#define EPS 1e-6f  // keeps norms away from zero

#endif  // CF_BUILTIN_KALMAN_CONSTANTS_H
