/* What the parts of the shim share: how a task waits for an object and who wakes it. */
#ifndef CF_BITCRAZE_RTOS_WAITS_H
#define CF_BITCRAZE_RTOS_WAITS_H

#include "bitcraze/freertos/freertos_shim.h"

// Why a task waits. The same queue may be awaited by who wants to send and by who wants to receive.
enum { CF_WAITS_TIME, CF_WAITS_ITEM, CF_WAITS_SPACE, CF_WAITS_EVENTS, CF_WAITS_NOTIFICATION };

// When a wait ends at the latest, so that one of several attempts ends as one of a single attempt.
// A tick, or never. An integer, since a struct in a waiting task's frame would have gaps.
typedef uint64_t cf_deadline_t;
#define CF_NEVER UINT64_MAX

TickType_t    cf_rtos_now(void);
cf_deadline_t cf_rtos_deadline(TickType_t wait);

// Whether who calls may wait: a task that is willing to.
bool cf_rtos_can_wait(TickType_t wait);

// For a task: returns true when somebody woke it, false when the time was over.
bool cf_rtos_wait(const void *object, int why, cf_deadline_t deadline);

// The waiting task of highest priority, of equal ones the one that has waited longest, is ready.
void cf_rtos_wake(const void *object, int why);
void cf_rtos_make_ready(StaticTask_t *task);

// All tasks, by number.
StaticTask_t *cf_rtos_task(int number);

bool cf_rtos_is_due(TickType_t at);

// Ends the drone with a sentence: format and what to put in.
_Noreturn void cf_rtos_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

void cf_rtos_copy_name(char to[17], const char *name);

// Calls the timers that are due. Returns whether there were any.
bool cf_timers_run(void);

// Forget all that was created.
void cf_timers_boot(void);
void cf_queues_boot(void);
void cf_events_boot(void);

#endif  // CF_BITCRAZE_RTOS_WAITS_H
