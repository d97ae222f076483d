/* Stands in for the header of the power management. Modules get the operating system through it. */
#ifndef CF_BITCRAZE_PM_H
#define CF_BITCRAZE_PM_H

#include <stdbool.h>
#include <stdint.h>

#include "FreeRTOS.h"
#include "task.h"

float pmGetBatteryVoltage(void);  // [V]
bool  pmIsChargerConnected(void);

#endif  // CF_BITCRAZE_PM_H
