/* The scheduler of the firmware's tasks, as the adapter sees it.
 *
 * Tasks are coroutines: the adapter sets the time and says when to run, and gets control back when
 * all tasks wait. Nothing depends on the computer's clock, so that equal flights are equal to the
 * bit. All that tasks remember, their stacks included, is part of the drone's image: between two
 * calls the drone can go to another copy of the library or into a snapshot.
 *
 * Every millisecond:
 *
 *   cf_rtos_set_time(now_ms);      delays and waits that end now make their tasks ready
 *   ... what interrupts do: measurements into queues, cf_rtos_signal_data_ready()
 *   cf_rtos_run_ready();
 *
 * A task that fails, by an assertion (cf_library_fail) or a crash, is left with a jump to the
 * simulation's stack (library/work.h), and the drone keeps its image as it was before. What this
 * copy of the library remembers outside of the image is which stack is in use, and that it sees
 * from the stack pointer; cf_rtos_boot() and cf_rtos_run_ready() do what else is to be done. There
 * is no need to call cf_rtos_abandon(), but it does no harm after cf_work_abandon().
 *
 * A task that neither waits nor yields, such as `while (1) {}`, is not noticed: it cannot be
 * stopped without a clock. */
#ifndef CF_BITCRAZE_RTOS_KERNEL_H
#define CF_BITCRAZE_RTOS_KERNEL_H

#include <stdbool.h>
#include <stdint.h>

// Forgets all tasks, timers and whatever was created without storage of its own. At a boot, with
// the image as the library was loaded, there is nothing to forget.
void cf_rtos_boot(void);

// The tick of the drone. Tasks whose delay or time-out is over become ready, and run with the next
// cf_rtos_run_ready() in the order of creation within their priority.
void cf_rtos_set_time(uint32_t now_ms);

// Runs ready tasks, highest priority first and within a priority in the order in which they became
// ready, until all wait; then due timers, in the order of creation, and the tasks these made ready.
// Fails when a task does not stop to yield.
void cf_rtos_run_ready(void);

// Whether the caller runs in a task, and not on the simulation's stack.
bool cf_rtos_is_in_task(void);

// The beat of the sensors: what sensorsWaitDataReady() waits for. A beat that is not awaited is
// kept, a second one is lost. Outside of tasks the wait returns at once.
void cf_rtos_wait_data_ready(void);
void cf_rtos_signal_data_ready(void);

// How many items found no room at the end of a queue.
extern uint32_t cf_rtos_refused;

// Tasks in the order of creation.
int         cf_rtos_task_count(void);
const char *cf_rtos_task_name(int task);  // null when there is none

// Forgets the task that was running when it was left by a jump.
void cf_rtos_abandon(void);

#endif  // CF_BITCRAZE_RTOS_KERNEL_H
