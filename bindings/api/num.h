/* The firmware's small number helpers, with its names (docs/reference/control-pid.md#8). */
#ifndef NUM_H
#define NUM_H

#include <stdint.h>

// Clamps to [0, 65535].
uint16_t limitUint16(int32_t value);

// Clamps to [minVal, maxVal]; NaN passes through.
float constrain(float value, float minVal, float maxVal);

// Moves the value towards zero by `threshold`; what is smaller becomes 0.
float deadband(float value, float threshold);

// Half precision as the firmware's logs use it: no subnormals (too small becomes +0), and a
// mantissa that rounds up past its ten bits is or-ed into the exponent.
uint16_t single2half(float number);
float    half2single(uint16_t number);

#endif  // NUM_H
