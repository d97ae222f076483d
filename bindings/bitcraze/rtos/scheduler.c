#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "bitcraze/rtos/coroutine.h"
#include "bitcraze/rtos/kernel.h"
#include "bitcraze/rtos/scheduler.h"
#include "library/inner.h"

#define WORD 8           // [bytes]
#define MAX_TURNS 1000   // within one tick
#define KEPT_BYTES 6144  // of all waiting tasks together: a few hundred each, and an app

static StaticTask_t *tasks[CF_STACKS];  // in the order of creation
static int           count;
static TickType_t    now;
static uint32_t      next_turn;

// What the waiting tasks use of their stacks, one behind the other in the order of creation, and
// zeros. Integers, since the distances in there are no pointers for the image map.
static struct {
  uint64_t words[KEPT_BYTES / WORD];
} kept;

// ------------------------------------------------------------------------------------------ help

_Noreturn void cf_rtos_fail(const char *format, ...) {
  char    sentence[200];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(sentence, sizeof sentence, format, arguments);
  va_end(arguments);
  cf_library_fail(sentence);
}

void cf_rtos_copy_name(char to[17], const char *name) {
  memset(to, 0, 17);
  if (name != NULL) {
    for (int i = 0; i < 16 && name[i] != 0; i++) {
      to[i] = name[i];
    }
  }
}

StaticTask_t *cf_rtos_current(void) {
  const int number = cf_coroutine_number();
  return number >= 0 && number < count ? tasks[number] : NULL;
}

bool cf_rtos_is_in_task(void) {
  return cf_coroutine_number() >= 0;
}

StaticTask_t *cf_rtos_task(int number) {
  return tasks[number];
}

int cf_rtos_task_count(void) {
  return count;
}

const char *cf_rtos_task_name(int task) {
  return task >= 0 && task < count ? tasks[task]->name : NULL;
}

// ------------------------------------------------------------------------------------------ time

TickType_t cf_rtos_now(void) {
  return now;
}

bool cf_rtos_is_due(TickType_t at) {
  return (int32_t)(now - at) >= 0;
}

cf_deadline_t cf_rtos_deadline(TickType_t wait) {
  return wait == portMAX_DELAY ? CF_NEVER : (TickType_t)(now + wait);
}

void cf_rtos_set_time(uint32_t now_ms) {
  now = now_ms;
  for (int i = 0; i < count; i++) {
    StaticTask_t *task = tasks[i];
    if (task->state == CF_TASK_WAITING && task->has_deadline && cf_rtos_is_due(task->deadline)) {
      cf_rtos_make_ready(task);
      task->was_woken = false;
    }
  }
}

// --------------------------------------------------------------------------------------- waiting

bool cf_rtos_can_wait(TickType_t wait) {
  return wait > 0 && cf_rtos_is_in_task();
}

static __attribute__((noinline)) bool wait_now(const void *object, int why,
                                               cf_deadline_t deadline) {
  StaticTask_t *task = cf_rtos_current();
  task->awaited      = object;
  task->why          = (uint8_t)why;
  task->deadline     = deadline == CF_NEVER ? 0 : (TickType_t)deadline;
  task->has_deadline = deadline != CF_NEVER;
  task->turn         = next_turn++;
  task->state        = CF_TASK_WAITING;
  cf_coroutine_wait();
  return task->was_woken;
}

bool cf_rtos_wait(const void *object, int why, cf_deadline_t deadline) {
  cf_coroutine_clean();
  return wait_now(object, why, deadline);
}

void cf_rtos_make_ready(StaticTask_t *task) {
  task->state        = CF_TASK_READY;
  task->was_woken    = true;
  task->awaited      = NULL;
  task->has_deadline = false;
  task->turn         = next_turn++;
}

static bool runs_before(const StaticTask_t *a, const StaticTask_t *b) {
  return a->priority != b->priority ? a->priority > b->priority : (int32_t)(a->turn - b->turn) < 0;
}

void cf_rtos_wake(const void *object, int why) {
  StaticTask_t *first = NULL;
  for (int i = 0; i < count; i++) {
    StaticTask_t *task = tasks[i];
    if (task->state == CF_TASK_WAITING && task->why == why && task->awaited == object &&
        (first == NULL || runs_before(task, first))) {
      first = task;
    }
  }
  if (first != NULL) {
    cf_rtos_make_ready(first);
  }
}

void cf_rtos_yield(void) {
  StaticTask_t *task = cf_rtos_current();
  if (task != NULL) {
    task->turn = next_turn++;
    cf_coroutine_wait();
  }
}

// ---------------------------------------------------------------------------------- in and out

static uint64_t *slice_of(const StaticTask_t *task) {
  uint64_t *slice = kept.words;
  for (int i = 0; i < task->number; i++) {
    slice += tasks[i]->in_use / WORD;
  }
  return slice;
}

static uint32_t kept_bytes(void) {
  uint32_t bytes = 0;
  for (int i = 0; i < count; i++) {
    bytes += tasks[i]->in_use;
  }
  return bytes;
}

// Makes room for as many bytes, or closes a gap; the slices of later tasks move.
static void resize(StaticTask_t *task, uint32_t bytes) {
  const uint32_t total  = kept_bytes() - task->in_use + bytes;
  char          *slice  = (char *)slice_of(task);
  char          *behind = slice + task->in_use;
  if (total > sizeof kept) {
    cf_rtos_fail(
        "task '%s' waits with %u bytes on its stack, %u with those of the other tasks; allowed: %u",
        task->name, (unsigned)bytes, (unsigned)total, (unsigned)sizeof kept);
  }
  char *end = (char *)kept.words + kept_bytes();
  memmove(slice + bytes, behind, (size_t)(end - behind));
  task->in_use = bytes;
  if (end > (char *)kept.words + total) {
    memset((char *)kept.words + total, 0, (size_t)(end - ((char *)kept.words + total)));
  }
}

static void work(int number) {
  StaticTask_t *task = tasks[number];
  task->entry(task->argument);
  // FreeRTOS does not allow this; here the task is over
  task->state = CF_TASK_ENDED;
  cf_coroutine_wait();
  __builtin_unreachable();
}

static void run(StaticTask_t *task) {
  const size_t in_use =
      cf_coroutine_resume(task->number, slice_of(task), task->in_use / WORD, work);
  if (!cf_coroutine_is_intact(task->number)) {
    cf_rtos_fail("stack of task '%s' overflowed (%d bytes)", task->name, CF_STACK_BYTES);
  }
  const size_t bytes = task->state == CF_TASK_ENDED ? 0 : in_use;
  if (bytes > CF_SLICE_BYTES) {
    cf_rtos_fail("task '%s' waits with %zu bytes on its stack, allowed: %d", task->name, bytes,
                 CF_SLICE_BYTES);
  }
  if (bytes != task->in_use) {
    resize(task, (uint32_t)bytes);
  }
  cf_coroutine_keep(task->number, slice_of(task), bytes / WORD);
}

static StaticTask_t *next(void) {
  StaticTask_t *first = NULL;
  for (int i = 0; i < count; i++) {
    if (tasks[i]->state == CF_TASK_READY && (first == NULL || runs_before(tasks[i], first))) {
      first = tasks[i];
    }
  }
  return first;
}

void cf_scheduler_run(int *turns) {
  for (StaticTask_t *task = next(); task != NULL; task = next()) {
    if ((*turns)++ == MAX_TURNS) {
      cf_rtos_fail("task '%s' does not come to wait: %d turns within one tick", task->name,
                   MAX_TURNS);
    }
    run(task);
  }
}

// ------------------------------------------------------------------------------- begin and end

void cf_scheduler_boot(void) {
  memset(tasks, 0, sizeof tasks);
  memset(&kept, 0, sizeof kept);
  count = 0;
  now = next_turn = 0;
}

void cf_scheduler_add(StaticTask_t *task, const char *name, TaskFunction_t entry, void *argument,
                      UBaseType_t priority) {
  if (count == CF_STACKS) {
    cf_rtos_fail("no place for task '%s': there are %d already", name, CF_STACKS);
  }
  for (int i = 0; i < count; i++) {
    if (tasks[i] == task) {
      cf_rtos_fail("task '%s' is created in the place of task '%s'", name, task->name);
    }
  }
  *task = (StaticTask_t){.entry    = entry,
                         .argument = argument,
                         .priority = (uint32_t)priority,
                         .number   = (uint8_t)count};
  cf_rtos_copy_name(task->name, name);
  tasks[count++] = task;
  cf_rtos_make_ready(task);
}

void cf_scheduler_stop(StaticTask_t *task, uint8_t state) {
  if (task != NULL && task->state != CF_TASK_ENDED) {
    task->state        = state;
    task->awaited      = NULL;
    task->has_deadline = false;
    if (task == cf_rtos_current()) {
      cf_coroutine_wait();
    } else if (state == CF_TASK_ENDED) {
      resize(task, 0);
    }
  }
}
