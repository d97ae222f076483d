/* The part of FreeRTOS that the firmware uses, over a scheduler without threads (rtos/kernel.h).
 *
 * Names, arguments and results are those of FreeRTOS. One tick is a millisecond of the drone. All
 * that a handle points to is part of the drone's image, therefore handles are typed pointers to
 * complete structs: debug information shows where pointers are. Only rtos/ accesses members of
 * the structs.
 *
 * A call from a task blocks up to its timeout. A call from elsewhere (init functions, callbacks of
 * timers, the simulation) returns the result for a timeout of 0. A task runs until it waits or
 * yields. No task is preempted: a task that gives a semaphore to a task of higher priority runs
 * until it waits or yields itself. */
#ifndef CF_BITCRAZE_FREERTOS_SHIM_H
#define CF_BITCRAZE_FREERTOS_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// ---------------------------------------------------------------------------------- plain types

typedef uint32_t      TickType_t;
typedef long          BaseType_t;
typedef unsigned long UBaseType_t;
typedef uint8_t       StackType_t;  // a task runs on a stack of ours: the firmware's are idle
typedef uint32_t      EventBits_t;
typedef TickType_t    portTickType;
typedef BaseType_t    portBASE_TYPE;

#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)
#define pdFAIL pdFALSE
#define pdPASS pdTRUE
#define errQUEUE_EMPTY pdFALSE
#define errQUEUE_FULL pdFALSE

#define portMAX_DELAY ((TickType_t)0xffffffff)
#define portTICK_PERIOD_MS ((TickType_t)1)
#define portTICK_RATE_MS portTICK_PERIOD_MS
#define pdMS_TO_TICKS(ms_) ((TickType_t)(ms_))
#define pdTICKS_TO_MS(ticks_) ((TickType_t)(ticks_))

// ----------------------------------------------------------------------------------------- tasks

typedef void (*TaskFunction_t)(void *);
typedef TaskFunction_t pdTASK_CODE;
typedef BaseType_t (*TaskHookFunction_t)(void *);

typedef struct cf_task_s {
  TaskFunction_t entry;
  void          *argument;
  const void    *awaited;  // what it waits for: a queue, a group of events, its notification
  uint32_t       priority;
  uint32_t       turn;        // of two ready tasks of one priority the smaller one runs first
  TickType_t     deadline;    // of the wait, if it has one
  uint32_t       in_use;      // [bytes] of its stack, kept while it waits
  uint32_t       notified;    // value of its notification
  uint32_t       event_bits;  // that it waits for; then those that it got
  uint8_t        state;
  uint8_t        why;  // it waits
  bool           has_deadline;
  bool           was_woken;  // before the deadline
  bool           wants_all_events;
  bool           clears_events;
  uint8_t        number;  // by order of creation
  char           name[17];
} StaticTask_t;
typedef StaticTask_t *TaskHandle_t;
typedef TaskHandle_t  xTaskHandle;

#define tskIDLE_PRIORITY ((UBaseType_t)0)
#define taskSCHEDULER_SUSPENDED ((BaseType_t)0)
#define taskSCHEDULER_NOT_STARTED ((BaseType_t)1)
#define taskSCHEDULER_RUNNING ((BaseType_t)2)

TaskHandle_t xTaskCreateStatic(TaskFunction_t entry, const char *name, uint32_t depth,
                               void *argument, UBaseType_t priority, StackType_t *stack,
                               StaticTask_t *task);
BaseType_t   xTaskCreate(TaskFunction_t entry, const char *name, uint32_t depth, void *argument,
                         UBaseType_t priority, TaskHandle_t *handle);
// A deleted task is not called any more; its place in the table stays taken.
void vTaskDelete(TaskHandle_t task);
void vTaskSuspend(TaskHandle_t task);
void vTaskResume(TaskHandle_t task);

TickType_t xTaskGetTickCount(void);
void       vTaskDelay(TickType_t ticks);
BaseType_t xTaskDelayUntil(TickType_t *previous, TickType_t increment);
void       vTaskDelayUntil(TickType_t *previous, TickType_t increment);
// To the end of the queue of ready tasks of this priority.
void cf_rtos_yield(void);

TaskHandle_t xTaskGetCurrentTaskHandle(void);  // null outside of tasks
char        *pcTaskGetName(TaskHandle_t task);
UBaseType_t  uxTaskPriorityGet(TaskHandle_t task);
void         vTaskPrioritySet(TaskHandle_t task, UBaseType_t priority);
UBaseType_t  uxTaskGetStackHighWaterMark(TaskHandle_t task);
UBaseType_t  uxTaskGetNumberOfTasks(void);
BaseType_t   xTaskGetSchedulerState(void);
void         vTaskSetApplicationTaskTag(TaskHandle_t task, TaskHookFunction_t tag);
size_t       xPortGetFreeHeapSize(void);

uint32_t   ulTaskNotifyTake(BaseType_t clears, TickType_t wait);
BaseType_t xTaskNotifyGive(TaskHandle_t task);
void       vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *woken);

#define xTaskGetTickCountFromISR() xTaskGetTickCount()
#define vTaskSuspendAll() ((void)0)
#define xTaskResumeAll() pdFALSE
#define taskYIELD() cf_rtos_yield()
#define portYIELD() cf_rtos_yield()
#define portYIELD_FROM_ISR(woken_) ((void)(woken_))
#define portEND_SWITCHING_ISR(woken_) ((void)(woken_))
#define taskENTER_CRITICAL() ((void)0)
#define taskEXIT_CRITICAL() ((void)0)
#define taskENTER_CRITICAL_FROM_ISR() ((UBaseType_t)0)
#define taskEXIT_CRITICAL_FROM_ISR(mask_) ((void)(mask_))
#define taskDISABLE_INTERRUPTS() ((void)0)
#define taskENABLE_INTERRUPTS() ((void)0)
#define portENTER_CRITICAL() ((void)0)
#define portEXIT_CRITICAL() ((void)0)
#define portDISABLE_INTERRUPTS() ((void)0)
#define portENABLE_INTERRUPTS() ((void)0)

// ---------------------------------------------------------------------- queues and semaphores

typedef struct cf_queue_s {
  uint8_t          *storage;  // null: a semaphore, of which only the count matters
  struct cf_task_s *holder;   // of a mutex
  uint32_t          length;
  uint32_t          item_bytes;
  uint32_t          count;
  uint32_t          head;  // the oldest item
  bool              is_mutex;
} StaticQueue_t;
typedef StaticQueue_t *QueueHandle_t;
typedef QueueHandle_t  xQueueHandle;
typedef StaticQueue_t  StaticSemaphore_t;
typedef QueueHandle_t  SemaphoreHandle_t;
typedef QueueHandle_t  xSemaphoreHandle;

QueueHandle_t xQueueCreateStatic(UBaseType_t length, UBaseType_t item_bytes, uint8_t *storage,
                                 StaticQueue_t *queue);
QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t item_bytes);
void          vQueueDelete(QueueHandle_t queue);
BaseType_t    xQueueSendToBack(QueueHandle_t queue, const void *item, TickType_t wait);
BaseType_t    xQueueSendToFront(QueueHandle_t queue, const void *item, TickType_t wait);
BaseType_t    xQueueOverwrite(QueueHandle_t queue, const void *item);
BaseType_t    xQueueReceive(QueueHandle_t queue, void *item, TickType_t wait);
BaseType_t    xQueuePeek(QueueHandle_t queue, void *item, TickType_t wait);
BaseType_t    xQueueReset(QueueHandle_t queue);
UBaseType_t   uxQueueMessagesWaiting(QueueHandle_t queue);
UBaseType_t   uxQueueSpacesAvailable(QueueHandle_t queue);

// From interrupts: these calls neither block nor request a context switch. A woken task runs at its
// turn.
BaseType_t xQueueSendToBackFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken);
BaseType_t xQueueSendToFrontFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken);
BaseType_t xQueueOverwriteFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken);
BaseType_t xQueueReceiveFromISR(QueueHandle_t queue, void *item, BaseType_t *woken);
BaseType_t xQueuePeekFromISR(QueueHandle_t queue, void *item);

#define xQueueSend(queue_, item_, wait_) xQueueSendToBack(queue_, item_, wait_)
#define xQueueSendFromISR(queue_, item_, woken_) xQueueSendToBackFromISR(queue_, item_, woken_)
#define uxQueueMessagesWaitingFromISR(queue_) uxQueueMessagesWaiting(queue_)
#define xQueueIsQueueEmptyFromISR(queue_) ((BaseType_t)(uxQueueMessagesWaiting(queue_) == 0))
#define xQueueIsQueueFullFromISR(queue_) ((BaseType_t)(uxQueueSpacesAvailable(queue_) == 0))
#define vQueueAddToRegistry(queue_, name_) ((void)(queue_), (void)(name_))

SemaphoreHandle_t xSemaphoreCreateBinary(void);  // empty
SemaphoreHandle_t xSemaphoreCreateBinaryStatic(StaticSemaphore_t *semaphore);
SemaphoreHandle_t xSemaphoreCreateCounting(UBaseType_t most, UBaseType_t count);
SemaphoreHandle_t xSemaphoreCreateCountingStatic(UBaseType_t most, UBaseType_t count,
                                                 StaticSemaphore_t *semaphore);
SemaphoreHandle_t xSemaphoreCreateMutex(void);  // free
SemaphoreHandle_t xSemaphoreCreateMutexStatic(StaticSemaphore_t *semaphore);
BaseType_t        xSemaphoreTake(SemaphoreHandle_t semaphore, TickType_t wait);
BaseType_t        xSemaphoreGive(SemaphoreHandle_t semaphore);
BaseType_t        xSemaphoreTakeFromISR(SemaphoreHandle_t semaphore, BaseType_t *woken);
BaseType_t        xSemaphoreGiveFromISR(SemaphoreHandle_t semaphore, BaseType_t *woken);

#define vSemaphoreDelete(semaphore_) vQueueDelete(semaphore_)
#define uxSemaphoreGetCount(semaphore_) uxQueueMessagesWaiting(semaphore_)
#define vSemaphoreCreateBinary(semaphore_)   \
  do {                                       \
    (semaphore_) = xSemaphoreCreateBinary(); \
    (void)xSemaphoreGive(semaphore_);        \
  } while (0)

// ---------------------------------------------------------------------------------------- timers

struct cf_timer_s;
typedef void (*TimerCallbackFunction_t)(struct cf_timer_s *timer);
typedef TimerCallbackFunction_t tmrTIMER_CALLBACK;

typedef struct cf_timer_s {
  TimerCallbackFunction_t callback;
  void                   *id;
  struct cf_timer_s      *next;  // by order of creation
  TickType_t              period;
  TickType_t              expiry;
  bool                    is_active;
  bool                    is_periodic;
  char                    name[17];
} StaticTimer_t;
typedef StaticTimer_t *TimerHandle_t;
typedef TimerHandle_t  xTimerHandle;

TimerHandle_t xTimerCreateStatic(const char *name, TickType_t period, UBaseType_t is_periodic,
                                 void *id, TimerCallbackFunction_t callback, StaticTimer_t *timer);
TimerHandle_t xTimerCreate(const char *name, TickType_t period, UBaseType_t is_periodic, void *id,
                           TimerCallbackFunction_t callback);
BaseType_t    xTimerStart(TimerHandle_t timer, TickType_t wait);
BaseType_t    xTimerStop(TimerHandle_t timer, TickType_t wait);
BaseType_t    xTimerChangePeriod(TimerHandle_t timer, TickType_t period, TickType_t wait);
BaseType_t    xTimerIsTimerActive(TimerHandle_t timer);
void         *pvTimerGetTimerID(TimerHandle_t timer);
void          vTimerSetTimerID(TimerHandle_t timer, void *id);
char         *pcTimerGetName(TimerHandle_t timer);
TickType_t    xTimerGetPeriod(TimerHandle_t timer);
TickType_t    xTimerGetExpiryTime(TimerHandle_t timer);

#define xTimerReset(timer_, wait_) xTimerStart(timer_, wait_)
#define xTimerDelete(timer_, wait_) xTimerStop(timer_, wait_)
#define xTimerStartFromISR(timer_, woken_) ((void)(woken_), xTimerStart(timer_, 0))
#define xTimerResetFromISR(timer_, woken_) ((void)(woken_), xTimerStart(timer_, 0))
#define xTimerStopFromISR(timer_, woken_) ((void)(woken_), xTimerStop(timer_, 0))
#define xTimerChangePeriodFromISR(timer_, period_, woken_) \
  ((void)(woken_), xTimerChangePeriod(timer_, period_, 0))

// ---------------------------------------------------------------------------------------- events

typedef struct cf_events_s {
  EventBits_t bits;
} StaticEventGroup_t;
typedef StaticEventGroup_t *EventGroupHandle_t;

EventGroupHandle_t xEventGroupCreateStatic(StaticEventGroup_t *group);
EventGroupHandle_t xEventGroupCreate(void);
EventBits_t        xEventGroupSetBits(EventGroupHandle_t group, EventBits_t bits);
EventBits_t        xEventGroupClearBits(EventGroupHandle_t group, EventBits_t bits);
EventBits_t xEventGroupWaitBits(EventGroupHandle_t group, EventBits_t bits, BaseType_t clears,
                                BaseType_t wants_all, TickType_t wait);

#define xEventGroupGetBits(group_) xEventGroupClearBits(group_, 0)
#define xEventGroupGetBitsFromISR(group_) xEventGroupClearBits(group_, 0)
#define xEventGroupClearBitsFromISR(group_, bits_) xEventGroupClearBits(group_, bits_)
#define xEventGroupSetBitsFromISR(group_, bits_, woken_) \
  ((void)(woken_), xEventGroupSetBits(group_, bits_), pdPASS)
#define vEventGroupDelete(group_) ((void)(group_))

#endif  // CF_BITCRAZE_FREERTOS_SHIM_H
