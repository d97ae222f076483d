/* Included before every source of a checkout and of an app (-include): what the vehicle's tool
 * chain gives them, and a host's does not.
 *
 * Some sources call abs() and the like without the header that declares it: old compilers guess,
 * new ones refuse. */
#ifndef CF_LIBRARY_PROLOGUE_H
#define CF_LIBRARY_PROLOGUE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// A type of ARM compilers, in which half precision numbers are stored, never computed.
#ifndef __ARM_FP16_FORMAT_IEEE
#define __fp16 uint16_t
#endif

#endif  // CF_LIBRARY_PROLOGUE_H
