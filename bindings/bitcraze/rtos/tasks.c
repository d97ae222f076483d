#include <string.h>

#include "bitcraze/rtos/coroutine.h"
#include "bitcraze/rtos/kernel.h"
#include "bitcraze/rtos/scheduler.h"

static StaticTask_t pool[CF_STACKS];  // of those that brought no storage
static int          taken;

void cf_tasks_boot(void) {
  memset(pool, 0, sizeof pool);
  taken = 0;
}

TaskHandle_t xTaskCreateStatic(TaskFunction_t entry, const char *name, uint32_t depth,
                               void *argument, UBaseType_t priority, StackType_t *stack,
                               StaticTask_t *task) {
  (void)depth;
  (void)stack;
  cf_scheduler_add(task, name, entry, argument, priority);
  return task;
}

BaseType_t xTaskCreate(TaskFunction_t entry, const char *name, uint32_t depth, void *argument,
                       UBaseType_t priority, TaskHandle_t *handle) {
  // there are as many in the pool as may be created at all
  StaticTask_t *task = taken < CF_STACKS ? &pool[taken++] : &pool[CF_STACKS - 1];
  xTaskCreateStatic(entry, name, depth, argument, priority, NULL, task);
  if (handle != NULL) {
    *handle = task;
  }
  return pdPASS;
}

static StaticTask_t *meant(TaskHandle_t task) {
  return task != NULL ? task : cf_rtos_current();
}

void vTaskDelete(TaskHandle_t task) {
  cf_scheduler_stop(meant(task), CF_TASK_ENDED);
}

void vTaskSuspend(TaskHandle_t task) {
  cf_scheduler_stop(meant(task), CF_TASK_SUSPENDED);
}

// A task that was waiting for a queue checks it again and goes on waiting; a wait for events ends.
void vTaskResume(TaskHandle_t task) {
  if (task != NULL && task->state == CF_TASK_SUSPENDED) {
    cf_rtos_make_ready(task);
    task->was_woken = task->why != CF_WAITS_EVENTS;
  }
}

TaskHandle_t xTaskGetCurrentTaskHandle(void) {
  return cf_rtos_current();
}

char *pcTaskGetName(TaskHandle_t task) {
  StaticTask_t *named = meant(task);
  return named != NULL ? named->name : NULL;
}

UBaseType_t uxTaskPriorityGet(TaskHandle_t task) {
  const StaticTask_t *asked = meant(task);
  return asked != NULL ? asked->priority : tskIDLE_PRIORITY;
}

void vTaskPrioritySet(TaskHandle_t task, UBaseType_t priority) {
  StaticTask_t *changed = meant(task);
  if (changed != NULL) {
    changed->priority = (uint32_t)priority;
  }
}

UBaseType_t uxTaskGetStackHighWaterMark(TaskHandle_t task) {
  (void)task;
  return 1000;
}

UBaseType_t uxTaskGetNumberOfTasks(void) {
  return (UBaseType_t)cf_rtos_task_count();
}

BaseType_t xTaskGetSchedulerState(void) {
  return taskSCHEDULER_RUNNING;
}

void vTaskSetApplicationTaskTag(TaskHandle_t task, TaskHookFunction_t tag) {
  (void)task;
  (void)tag;
}

size_t xPortGetFreeHeapSize(void) {
  return 10000;
}

// ----------------------------------------------------------------------------------------- delays

TickType_t xTaskGetTickCount(void) {
  return cf_rtos_now();
}

void vTaskDelay(TickType_t ticks) {
  if (ticks == 0) {
    cf_rtos_yield();
  } else if (cf_rtos_is_in_task()) {
    cf_rtos_wait(NULL, CF_WAITS_TIME, cf_rtos_deadline(ticks));
  }
}

BaseType_t xTaskDelayUntil(TickType_t *previous, TickType_t increment) {
  *previous += increment;
  const bool is_late = cf_rtos_is_due(*previous);
  if (!is_late && cf_rtos_is_in_task()) {
    cf_rtos_wait(NULL, CF_WAITS_TIME, *previous);
  }
  return is_late ? pdFALSE : pdTRUE;
}

void vTaskDelayUntil(TickType_t *previous, TickType_t increment) {
  xTaskDelayUntil(previous, increment);
}

// --------------------------------------------------------------------------------- notifications

uint32_t ulTaskNotifyTake(BaseType_t clears, TickType_t wait) {
  StaticTask_t *task = cf_rtos_current();
  if (task == NULL) {
    return 0;
  }
  if (task->notified == 0 && wait > 0) {
    cf_rtos_wait(&task->notified, CF_WAITS_NOTIFICATION, cf_rtos_deadline(wait));
  }
  const uint32_t value = task->notified;
  if (value > 0) {
    task->notified = clears != pdFALSE ? 0 : value - 1;
  }
  return value;
}

BaseType_t xTaskNotifyGive(TaskHandle_t task) {
  task->notified++;
  cf_rtos_wake(&task->notified, CF_WAITS_NOTIFICATION);
  return pdPASS;
}

void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *woken) {
  (void)woken;
  xTaskNotifyGive(task);
}
