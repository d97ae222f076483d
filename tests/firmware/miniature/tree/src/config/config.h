#ifndef CONFIG_H_
#define CONFIG_H_

#include <stdint.h>

#include "nrf24l01.h"
#include "trace.h"

#define M2T(X) ((unsigned int)(X))
#define F2T(X) ((unsigned int)(1000 / (X)))
#define T2M(X) ((unsigned int)(X))
#define T2S(X) ((X) / 1000.0f)

#endif  // CONFIG_H_
