/* Square root of a covariance, for the robust models. Internal to C. */
#ifndef CF_BUILTIN_KALMAN_CHOLESKY_H
#define CF_BUILTIN_KALMAN_CHOLESKY_H

// L L' = P with zeros above the diagonal of L, from the lower triangle of P. Rounding makes a large
// covariance indefinite, as it is for some loops after a reset. The firmware's root is NaN there,
// and the estimate with it; here that place of the diagonal is 1e-4 and the column below it zero.
void cf_cholesky(float L[9][9], const float P[9][9]);

// The inverse of a matrix with zeros above its diagonal and none on it.
void cf_invert_lower(float inverse[9][9], const float L[9][9]);

#endif  // CF_BUILTIN_KALMAN_CHOLESKY_H
