/* Stands in for the operating system's header, for modules that ask it for the time only. One tick
 * is a millisecond. */
#ifndef CF_BITCRAZE_FREERTOS_H
#define CF_BITCRAZE_FREERTOS_H

#include <stddef.h>
#include <stdint.h>

typedef uint32_t      TickType_t;
typedef long          BaseType_t;
typedef unsigned long UBaseType_t;

#define configTICK_RATE_HZ 1000
#define portTICK_RATE_MS ((TickType_t)1)
#define portTICK_PERIOD_MS ((TickType_t)1)
#define portMAX_DELAY ((TickType_t)0xffffffff)

#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)

#endif  // CF_BITCRAZE_FREERTOS_H
