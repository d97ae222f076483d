/* Stands in for the registers of the processor: see stm32fxxx.h. */
#ifndef CF_BITCRAZE_STM32F4XX_H
#define CF_BITCRAZE_STM32F4XX_H

#include "stm32fxxx.h"

#endif  // CF_BITCRAZE_STM32F4XX_H
