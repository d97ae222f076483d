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

// of the firmware's FreeRTOSConfig.h: milliseconds to ticks and back, frequency [Hz] to ticks
#ifndef M2T
#define M2T(X) ((TickType_t)(X))
#define T2M(X) ((unsigned int)(X))
#define F2T(X) ((TickType_t)(configTICK_RATE_HZ / (X)))
#endif

#endif  // CF_BITCRAZE_FREERTOS_H
