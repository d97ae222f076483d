/* One turn of the sine, for fast_math.c. Internal to C. */
#ifndef CF_BUILTIN_MATH_SINE_TABLE_H
#define CF_BUILTIN_MATH_SINE_TABLE_H

#define CF_SINE_TABLE_SEGMENTS 512

extern const float CF_SINE_TABLE[CF_SINE_TABLE_SEGMENTS + 1];

#endif  // CF_BUILTIN_MATH_SINE_TABLE_H
