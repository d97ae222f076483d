/* Included before every source of a checkout and of an app (-include), which is how they find on a
 * host what the vehicle's tool chain gives them.
 *
 * Some sources call abs() and the like without the header that declares it: old compilers guess,
 * new ones refuse. log.h and param.h come here so that they are ours wherever the sources get
 * theirs from: a quoted include looks beside the file that includes, before any -I. */
#ifndef CF_LIBRARY_PROLOGUE_H
#define CF_LIBRARY_PROLOGUE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "param.h"

// A type of ARM compilers, in which half precision numbers are stored, never computed.
#ifndef __ARM_FP16_FORMAT_IEEE
#define __fp16 uint16_t
#endif

#endif  // CF_LIBRARY_PROLOGUE_H
