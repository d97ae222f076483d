// The header of the processor, by the processor.
#ifndef STM32FXXX_H_
#define STM32FXXX_H_

#if defined(STM32F40_41xxx)
#include "stm32f4xx.h"
#else
#warning "Don't know which stm32fxxx header file to include"
#endif

#endif  // STM32FXXX_H_
