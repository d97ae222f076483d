/* Stands in for the header of the vehicle's processor, which warns on any other one. */
#ifndef CF_SHADOW_STM32FXXX_H
#define CF_SHADOW_STM32FXXX_H

#include "stm32f4xx.h"

#endif  // CF_SHADOW_STM32FXXX_H
