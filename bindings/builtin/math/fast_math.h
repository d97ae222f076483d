/* Sine and cosine by table, as the filter of the firmware takes them
 * (docs/reference/estimators.md#2).
 *
 * They are off by up to 2e-5 from the true values, far more than float rounding, so that libm is no
 * substitute where the bits shall agree. */
#ifndef CF_BUILTIN_MATH_FAST_MATH_H
#define CF_BUILTIN_MATH_FAST_MATH_H

// Return the sine or cosine of x [rad] by linear interpolation in a table of 512 segments. Beyond
// 1e8 rad, where a float no longer resolves a turn, they return 0; NaN and infinity give NaN.
float cf_fast_sin(float x);
float cf_fast_cos(float x);

#endif  // CF_BUILTIN_MATH_FAST_MATH_H
