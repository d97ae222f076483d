/* Stands in for the operating system's header: see freertos_shim.h. */
#ifndef CF_BITCRAZE_SEMPHR_H
#define CF_BITCRAZE_SEMPHR_H

#include "FreeRTOS.h"

#endif  // CF_BITCRAZE_SEMPHR_H
