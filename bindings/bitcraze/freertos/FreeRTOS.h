/* Stands in for the operating system's header: see freertos_shim.h. */
#ifndef CF_BITCRAZE_FREERTOS_H
#define CF_BITCRAZE_FREERTOS_H

// The checkout's own: milliseconds to ticks (M2T), identifiers of tasks, config.h, cfassert.h.
#if __has_include("FreeRTOSConfig.h")
#include "FreeRTOSConfig.h"
#endif

#ifndef configTICK_RATE_HZ
#define configTICK_RATE_HZ 1000
#endif
#ifndef configMINIMAL_STACK_SIZE
#define configMINIMAL_STACK_SIZE 150
#endif
#ifndef configMAX_PRIORITIES
#define configMAX_PRIORITIES 6
#endif
#ifndef configMAX_TASK_NAME_LEN
#define configMAX_TASK_NAME_LEN 10
#endif
#ifndef configASSERT
#define configASSERT(condition_) \
  do {                           \
    if (!(condition_)) {         \
      __builtin_trap();          \
    }                            \
  } while (0)
#endif

#include "freertos_shim.h"

#endif  // CF_BITCRAZE_FREERTOS_H
