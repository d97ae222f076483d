#include <string.h>

#include "bitcraze/rtos/kernel.h"
#include "bitcraze/rtos/scheduler.h"

#define POOL_GROUPS 8

static StaticEventGroup_t pool[POOL_GROUPS];  // for those that bring no storage
static int                taken;

void cf_events_boot(void) {
  memset(pool, 0, sizeof pool);
  taken = 0;
}

EventGroupHandle_t xEventGroupCreateStatic(StaticEventGroup_t *group) {
  group->bits = 0;
  return group;
}

EventGroupHandle_t xEventGroupCreate(void) {
  if (taken == POOL_GROUPS) {
    cf_rtos_fail("no room for another group of events: %d were created without storage",
                 POOL_GROUPS);
  }
  return xEventGroupCreateStatic(&pool[taken++]);
}

static bool is_enough(EventBits_t there, EventBits_t wanted, bool wants_all) {
  return wants_all ? (there & wanted) == wanted : (there & wanted) != 0;
}

// A waiting task gets the bits as they are set now, even if other tasks clear them before it runs.
EventBits_t xEventGroupSetBits(EventGroupHandle_t group, EventBits_t bits) {
  EventBits_t cleared = 0;
  group->bits |= bits;
  for (int i = 0; i < cf_rtos_task_count(); i++) {
    StaticTask_t *task = cf_rtos_task(i);
    if (task->awaited == group && task->why == CF_WAITS_EVENTS &&
        is_enough(group->bits, task->event_bits, task->wants_all_events)) {
      cleared |= task->clears_events ? task->event_bits : 0;
      task->event_bits = group->bits;
      cf_rtos_make_ready(task);
    }
  }
  group->bits &= ~cleared;
  return group->bits;
}

// Returns the bits before.
EventBits_t xEventGroupClearBits(EventGroupHandle_t group, EventBits_t bits) {
  const EventBits_t before = group->bits;
  group->bits &= ~bits;
  return before;
}

EventBits_t xEventGroupWaitBits(EventGroupHandle_t group, EventBits_t bits, BaseType_t clears,
                                BaseType_t wants_all, TickType_t wait) {
  if (is_enough(group->bits, bits, wants_all != pdFALSE)) {
    return xEventGroupClearBits(group, clears != pdFALSE ? bits : 0);
  }
  if (cf_rtos_can_wait(wait)) {
    StaticTask_t *task     = xTaskGetCurrentTaskHandle();
    task->event_bits       = bits;
    task->clears_events    = clears != pdFALSE;
    task->wants_all_events = wants_all != pdFALSE;
    if (cf_rtos_wait(group, CF_WAITS_EVENTS, cf_rtos_deadline(wait))) {
      return task->event_bits;
    }
  }
  return group->bits;
}
