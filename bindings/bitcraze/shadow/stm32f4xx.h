/* Stands in for the registers of the vehicle's processor: there are none. */
#ifndef CF_SHADOW_STM32F4XX_H
#define CF_SHADOW_STM32F4XX_H

#endif  // CF_SHADOW_STM32F4XX_H
