/* What apps use of FreeRTOS.h and of the firmware's settings for it: types and times. One tick is a
 * millisecond. There are no tasks, queues or semaphores: see app.h. */
#ifndef CF_APP_FREERTOS_H
#define CF_APP_FREERTOS_H

#include <stddef.h>
#include <stdint.h>

typedef uint32_t      TickType_t;
typedef long          BaseType_t;
typedef unsigned long UBaseType_t;

#define configTICK_RATE_HZ 1000
#define portTICK_PERIOD_MS ((TickType_t)1)
#define portMAX_DELAY ((TickType_t)0xffffffff)

#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)
#define pdFAIL pdFALSE
#define pdPASS pdTRUE

#define M2T(X) ((TickType_t)(X))                         // milliseconds to ticks
#define T2M(X) ((unsigned int)(X))                       // ticks to milliseconds
#define F2T(X) ((TickType_t)(configTICK_RATE_HZ / (X)))  // frequency [Hz] to ticks

#endif  // CF_APP_FREERTOS_H
