/* A unit quaternion in 32 bits, with the names of the firmware's quatcompress.h.
 *
 * Order x, y, z, w. Bits 31 and 30 hold the index of the component with the largest magnitude,
 * which is left out; the other three follow in ascending order as a sign bit and nine bits of
 * magnitude, in steps of sqrt(1/2) / 511. Source: docs/reference/planner-commander.md#11. */
#ifndef QUATCOMPRESS_H
#define QUATCOMPRESS_H

#include <stdint.h>

// Returns the word of a unit quaternion. A component that no unit quaternion has is taken as the
// nearest one that fits.
uint32_t quatcompress(const float q[4]);

// Writes the quaternion of a word, with a positive largest component. A word that quatcompress
// never makes may have no such component: it is NaN then.
void quatdecompress(uint32_t comp, float q[4]);

#endif  // QUATCOMPRESS_H
