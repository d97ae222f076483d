/* Stands in for the operating system's header: see FreeRTOS.h. */
#ifndef CF_BITCRAZE_TASK_H
#define CF_BITCRAZE_TASK_H

#include "FreeRTOS.h"

TickType_t xTaskGetTickCount(void);
void       vTaskDelay(TickType_t ticks);

#endif  // CF_BITCRAZE_TASK_H
