#ifndef PM_H_
#define PM_H_

#include <stdbool.h>

#include "adc.h"
#include "deck.h"
#include "syslink.h"

typedef enum {
  battery,
  charging,
  charged,
  lowPower,
  shutDown,
} PMStates;

void  pmInit(void);
bool  pmTest(void);
float pmGetBatteryVoltage(void);
bool  pmIsBatteryLow(void);
bool  pmIsChargerConnected(void);

#endif  // PM_H_
