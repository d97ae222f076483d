/* The scheduler under the parts of the shim: time, tasks that wait for objects, and their turns. */
#ifndef CF_BITCRAZE_RTOS_SCHEDULER_H
#define CF_BITCRAZE_RTOS_SCHEDULER_H

#include "bitcraze/freertos/freertos_shim.h"

// Why a task waits. Senders (SPACE) and receivers (ITEM) may wait for the same queue.
enum { CF_WAITS_TIME, CF_WAITS_ITEM, CF_WAITS_SPACE, CF_WAITS_EVENTS, CF_WAITS_NOTIFICATION };

// When a wait ends at the latest, so that one of several attempts ends as one of a single attempt.
// A tick, or never. An integer, since a struct in a waiting task's frame would have gaps.
typedef uint64_t cf_deadline_t;
#define CF_NEVER UINT64_MAX

TickType_t    cf_rtos_now(void);
cf_deadline_t cf_rtos_deadline(TickType_t wait);

// Whether the caller may wait: it is a task, and passes a timeout above zero.
bool cf_rtos_can_wait(TickType_t wait);

// For a task: returns true when it was woken, false when the time was over.
bool cf_rtos_wait(const void *object, int why, cf_deadline_t deadline);

// The waiting task of highest priority, of equal ones the one that has waited longest, is ready.
void cf_rtos_wake(const void *object, int why);
void cf_rtos_make_ready(StaticTask_t *task);

// All tasks, by number, and the one that calls, or null.
StaticTask_t *cf_rtos_task(int number);
StaticTask_t *cf_rtos_current(void);

enum { CF_TASK_READY, CF_TASK_WAITING, CF_TASK_SUSPENDED, CF_TASK_ENDED };

// Forgets all tasks.
void cf_scheduler_boot(void);

// Makes a task, which is ready. Fails when there is no stack left, or its place is taken.
void cf_scheduler_add(StaticTask_t *task, const char *name, TaskFunction_t entry, void *argument,
                      UBaseType_t priority);

// Stops a task where it is: suspended or ended. Null is no task.
void cf_scheduler_stop(StaticTask_t *task, uint8_t state);

// Runs ready tasks until all wait. Counts turns, and fails when there are too many.
void cf_scheduler_run(int *turns);

bool cf_rtos_is_due(TickType_t at);

// Ends the drone with a sentence: format and what to put in.
_Noreturn void cf_rtos_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

void cf_rtos_copy_name(char to[17], const char *name);

// Calls the timers that are due. Returns whether there were any.
bool cf_timers_run(void);

// Forget all that was created.
void cf_tasks_boot(void);
void cf_timers_boot(void);
void cf_queues_boot(void);
void cf_events_boot(void);

#endif  // CF_BITCRAZE_RTOS_SCHEDULER_H
