// How the kernel is built. Comes through FreeRTOS.h, and brings what sources do not include.
#ifndef FREERTOS_CONFIG_H
#define FREERTOS_CONFIG_H

#include <stdint.h>
// clang-format off
#include "config.h"
#include "cfassert.h"
// clang-format on

#define configUSE_PREEMPTION 1
#define configUSE_IDLE_HOOK 1
#define configUSE_TICK_HOOK 0
#define configCPU_CLOCK_HZ ((unsigned long)FREERTOS_MCU_CLOCK_HZ)
#define configTICK_RATE_HZ_RAW 1000
#define configTICK_RATE_HZ ((TickType_t)configTICK_RATE_HZ_RAW)
#define configMINIMAL_STACK_SIZE ((unsigned short)FREERTOS_MIN_STACK_SIZE)
#define configTOTAL_HEAP_SIZE ((size_t)(FREERTOS_HEAP_SIZE))
#define configMAX_TASK_NAME_LEN (10)
#define configUSE_16_BIT_TICKS 0
#define configIDLE_SHOULD_YIELD 0
#define configUSE_CO_ROUTINES 0
#define configMAX_PRIORITIES (6)
#define configUSE_MUTEXES 1
#define configUSE_APPLICATION_TASK_TAG 1
#define configSUPPORT_STATIC_ALLOCATION 1
#define configUSE_TIMERS 1
#define configTIMER_TASK_PRIORITY 1
#define configTIMER_QUEUE_LENGTH 20
#define configTIMER_TASK_STACK_DEPTH (configMINIMAL_STACK_SIZE * 4)

// times in ticks, milliseconds and seconds
#if (configTICK_RATE_HZ_RAW != 1000)
#error "conversions below assume ticks of a millisecond"
#endif
#define M2T(X) ((unsigned int)(X))
#define F2T(X) ((unsigned int)((configTICK_RATE_HZ / (X))))
#define T2M(X) ((unsigned int)(X))
#define T2S(X) ((X) / (float)configTICK_RATE_HZ)
#define S2T(X) ((portTickType)((X) * configTICK_RATE_HZ))

#define TASK_LED_ID_NBR 1
#define TASK_RADIO_ID_NBR 2
#define TASK_STABILIZER_ID_NBR 3
#define TASK_ADC_ID_NBR 4
#define TASK_PM_ID_NBR 5
#define TASK_PROXIMITY_ID_NBR 6

#define configASSERT(x) \
  if ((x) == 0)         \
  assertFail(#x, __FILE__, __LINE__)

#ifdef DEBUG_QUEUE_MONITOR
#undef traceQUEUE_SEND
#undef traceQUEUE_SEND_FAILED
#define traceQUEUE_SEND(xQueue) qm_traceQUEUE_SEND(xQueue)
#define traceQUEUE_SEND_FAILED(xQueue) qm_traceQUEUE_SEND_FAILED(xQueue)
void qm_traceQUEUE_SEND(void *xQueue);
void qm_traceQUEUE_SEND_FAILED(void *xQueue);
#endif

#endif /* FREERTOS_CONFIG_H */
