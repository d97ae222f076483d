/* Stands in for the registers of the processor, as far as modules that compile on a host look at
 * them: no interrupt is ever at work. */
#ifndef CF_BITCRAZE_STM32FXXX_H
#define CF_BITCRAZE_STM32FXXX_H

#include <stdint.h>

typedef struct {
  uint32_t ICSR;
} SCB_Type;

__attribute__((unused)) static const SCB_Type cf_no_registers = {.ICSR = 0};
#define SCB (&cf_no_registers)
#define SCB_ICSR_VECTACTIVE_Msk 0x1ffu

// of motors.h
typedef struct {
} GPIO_TypeDef;
typedef struct {
} TIM_TypeDef;
typedef struct {
} TIM_OCInitTypeDef;

#endif  // CF_BITCRAZE_STM32FXXX_H
