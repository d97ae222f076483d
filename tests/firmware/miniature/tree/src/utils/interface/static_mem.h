// Where variables that DMA does not touch are put.
#pragma once

#include "cfassert.h"

#define NO_DMA_CCM_SAFE_ZERO_INIT __attribute__((section(".ccmbss")))
