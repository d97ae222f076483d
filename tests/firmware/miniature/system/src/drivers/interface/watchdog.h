#ifndef __WATCHDOG_H__
#define __WATCHDOG_H__

#include "stm32f4xx_iwdg.h"

#define watchdogReset() (IWDG_ReloadCounter())

void watchdogInit(void);

#endif  // __WATCHDOG_H__
