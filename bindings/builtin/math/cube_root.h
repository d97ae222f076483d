/* Cube roots of several floats at once, correctly rounded.
 *
 * libm's cbrtf differs in the last bit from version to version and handles one number at a time;
 * the battery compensation needs eight of them every second tick. */
#ifndef CF_BUILTIN_MATH_CUBE_ROOT_H
#define CF_BUILTIN_MATH_CUBE_ROOT_H

// out[i] = cbrt(x[i]). Infinities and NaN are returned as they are. The arrays may be the same.
void cf_cube_roots(const float *x, float *out, int count);

#endif  // CF_BUILTIN_MATH_CUBE_ROOT_H
