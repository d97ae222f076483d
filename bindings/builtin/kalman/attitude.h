/* Rotations of attitude and covariance that prediction and finalize share. Internal to C. */
#ifndef CF_BUILTIN_KALMAN_ATTITUDE_H
#define CF_BUILTIN_KALMAN_ATTITUDE_H

// product = q turned by the rotation vector [rad] in the body frame, not normalized.
void cf_attitude_turn(float product[4], const float q[4], const float rotation[3]);

// q = unit / (|unit| + 1e-6): the norm that is stored settles at 0.999999.
void cf_attitude_normalize(float q[4], const float unit[4]);

// How an attitude error moves to a frame turned by twice `half` [rad], to second order: the block
// of the transition matrix at rows and columns D0 to D2.
void cf_attitude_transition(float block[3][3], const float half[3]);

#endif  // CF_BUILTIN_KALMAN_ATTITUDE_H
