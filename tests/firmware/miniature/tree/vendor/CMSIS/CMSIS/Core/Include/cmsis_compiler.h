// What the DSP library wants of a compiler.
#ifndef CMSIS_COMPILER_H
#define CMSIS_COMPILER_H

#include <stdint.h>

#include "cmsis_gcc.h"

#define __STATIC_FORCEINLINE static inline

#endif  // CMSIS_COMPILER_H
