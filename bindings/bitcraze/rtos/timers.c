#include <string.h>

#include "bitcraze/rtos/scheduler.h"

#define POOL_TIMERS 8

static StaticTimer_t *first;              // in the order of creation
static StaticTimer_t  pool[POOL_TIMERS];  // for those that bring no storage
static int            taken;

void cf_timers_boot(void) {
  memset(pool, 0, sizeof pool);
  first = NULL;
  taken = 0;
}

static void append(StaticTimer_t *timer) {
  StaticTimer_t **end = &first;
  while (*end != NULL) {
    if (*end == timer) {
      cf_rtos_fail("timer '%s' is created a second time", timer->name);
    }
    end = &(*end)->next;
  }
  *end = timer;
}

static TickType_t at_least_one(TickType_t period) {
  return period > 0 ? period : 1;
}

TimerHandle_t xTimerCreateStatic(const char *name, TickType_t period, UBaseType_t is_periodic,
                                 void *id, TimerCallbackFunction_t callback, StaticTimer_t *timer) {
  append(timer);
  *timer = (StaticTimer_t){.callback    = callback,
                           .id          = id,
                           .period      = at_least_one(period),
                           .is_periodic = is_periodic != 0};
  cf_rtos_copy_name(timer->name, name);
  return timer;
}

TimerHandle_t xTimerCreate(const char *name, TickType_t period, UBaseType_t is_periodic, void *id,
                           TimerCallbackFunction_t callback) {
  if (taken == POOL_TIMERS) {
    cf_rtos_fail("no room for timer '%s': %d were created without storage", name, POOL_TIMERS);
  }
  return xTimerCreateStatic(name, period, is_periodic, id, callback, &pool[taken++]);
}

BaseType_t xTimerStart(TimerHandle_t timer, TickType_t wait) {
  (void)wait;
  timer->is_active = true;
  timer->expiry    = cf_rtos_now() + timer->period;
  return pdPASS;
}

BaseType_t xTimerStop(TimerHandle_t timer, TickType_t wait) {
  (void)wait;
  timer->is_active = false;
  return pdPASS;
}

// Starts a timer that stands still.
BaseType_t xTimerChangePeriod(TimerHandle_t timer, TickType_t period, TickType_t wait) {
  timer->period = at_least_one(period);
  return xTimerStart(timer, wait);
}

BaseType_t xTimerIsTimerActive(TimerHandle_t timer) {
  return timer->is_active ? pdTRUE : pdFALSE;
}

void *pvTimerGetTimerID(TimerHandle_t timer) {
  return timer->id;
}

void vTimerSetTimerID(TimerHandle_t timer, void *id) {
  timer->id = id;
}

char *pcTimerGetName(TimerHandle_t timer) {
  return timer->name;
}

TickType_t xTimerGetPeriod(TimerHandle_t timer) {
  return timer->period;
}

TickType_t xTimerGetExpiryTime(TimerHandle_t timer) {
  return timer->expiry;
}

// A timer that is late by several periods is called once.
static void plan_next(StaticTimer_t *timer) {
  timer->is_active = timer->is_periodic;
  while (timer->is_periodic && cf_rtos_is_due(timer->expiry)) {
    timer->expiry += timer->period;
  }
}

bool cf_timers_run(void) {
  bool is_called = false;
  for (StaticTimer_t *timer = first; timer != NULL; timer = timer->next) {
    if (timer->is_active && cf_rtos_is_due(timer->expiry)) {
      plan_next(timer);
      timer->callback(timer);
      is_called = true;
    }
  }
  return is_called;
}
