#ifndef __USDDECK_H__
#define __USDDECK_H__

#include <stdbool.h>

#include "deck.h"

bool usddeckLoggingEnabled(void);
int  usddeckFrequency(void);
void usddeckTriggerLogging(void);

#endif  // __USDDECK_H__
