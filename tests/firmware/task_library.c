// A library with tasks, for tests: the image and the rescue of a provider library around the shim
// of FreeRTOS, without the table of functions. A number selects what the tasks of a drone do.

#define _GNU_SOURCE  // sigaltstack

#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "FreeRTOS.h"
#include "bitcraze/rtos/kernel.h"
#include "library/image.h"
#include "library/inner.h"
#include "library/work.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"
#include "timers.h"

#define EXPORT __attribute__((visibility("default")))

enum { FLY, CRASH, RECURSE, ASSERT, LEAVE_DIRT };

// -------------------------------------------------------------------------------- what tasks do

static uint64_t      sum;  // of what the tasks saw
static uint32_t      laps;
static int           kind;
static QueueHandle_t numbers;

static void add(uint64_t number) {
  sum = (sum ^ number) * 0x100000001b3u;
}

typedef struct link_s {
  struct link_s *previous;
  uint32_t       value;
  void (*function)(uint64_t);
} link_t;

// Waits deep inside, with a chain of pointers through all the frames.
static __attribute__((noinline)) void descend(link_t *previous, int depth, char **message) {
  link_t link = {.previous = previous, .value = previous->value + 1, .function = add};
  if (depth > 0) {
    descend(&link, depth - 1, message);
  } else {
    vTaskDelay(2);
  }
  // after the wait, maybe at another address
  for (link_t *one = &link; one != NULL; one = one->previous) {
    one->function(one->value);
  }
  add((uint64_t)(*message)[depth]);
}

static void flies(void *step) {
  char   text[16] = "a local variable";
  char  *message  = text;
  link_t first    = {.value = *(uint32_t *)step, .function = add};
  for (;;) {
    descend(&first, 3 + (int)(laps % 3), &message);
    text[0]++;
    laps++;
    xQueueSend(numbers, &first.value, 0);
    first.value += *(uint32_t *)step;
  }
}

static void receives(void *unused) {
  (void)unused;
  uint32_t  number = 0;
  uint32_t *place  = &number;
  double    total  = 0.5;
  for (;;) {
    if (xQueueReceive(numbers, place, 3) == pdTRUE) {
      total = 0.75 * total + number;
    } else {
      total += 1.0;
    }
    uint64_t bits;
    memcpy(&bits, &total, sizeof bits);
    add(bits);
  }
}

static void waits_for_data(void *unused) {
  (void)unused;
  uint32_t step = 1;
  for (;;) {
    cf_rtos_wait_data_ready();
    add(step++);
  }
}

static void on_timer(TimerHandle_t timer) {
  add(xTaskGetTickCount() + *(uint32_t *)pvTimerGetTimerID(timer));
}

static volatile int zero;
static int *volatile nowhere;

static int recurse(int depth) {
  volatile char room[1024];
  room[0] = (char)depth;
  return recurse(depth + 1) + room[0];
}

// Leaves numbers of its own where others will have their frames.
static __attribute__((noinline)) void leave_dirt(uint64_t seed) {
  volatile uint64_t room[700];
  for (int i = 0; i < 700; i++) {
    room[i] = seed * 0x9e3779b97f4a7c15u + (uint64_t)i;
  }
}

static void goes_wrong(void *unused) {
  (void)unused;
  vTaskDelay(5);
  switch (kind) {
    case CRASH:
      add((uint64_t)*nowhere);
      break;
    case RECURSE:
      add((uint64_t)recurse(0));
      break;
    case ASSERT:
      cf_library_fail("assertion failed: thrust >= 0 (task.c:12)");
    default:
      for (uint64_t i = 0;; i++) {
        leave_dirt(i);
        vTaskDelay(1);
      }
  }
}

static uint32_t     step = 7;
static StaticTask_t flying, receiving;
static StackType_t  idle_stack[100];

static void start_tasks(void) {
  xTaskCreateStatic(flies, "FLY", 100, &step, 3, idle_stack, &flying);
  if (kind != FLY) {
    xTaskCreate(goes_wrong, "WRONG", 100, NULL, 1, NULL);
  }
  xTaskCreateStatic(receives, "RECEIVE", 100, NULL, 2, idle_stack, &receiving);
  xTaskCreate(waits_for_data, "DATA", 100, NULL, 5, NULL);
  xTimerStart(xTimerCreate("TIMER", 3, pdTRUE, &step, on_timer), 0);
}

// ----------------------------------------------------------------------------------- in the core

static sigjmp_buf *rescue          CF_LIBRARY_KEEP                       = NULL;
static char                        failure[256] CF_LIBRARY_KEEP          = "";
static char                        signal_stack[1 << 16] CF_LIBRARY_KEEP = "";
static stack_t old_stack           CF_LIBRARY_KEEP                       = {.ss_size = 0};
static struct sigaction old_action CF_LIBRARY_KEEP                       = {.sa_flags = 0};
static cf_image_map_t map          CF_LIBRARY_KEEP                       = {.n_ranges = 0};

static void handle(int signal) {
  if (rescue == NULL) {
    sigaction(signal, &old_action, NULL);  // the previous handler gets the repeated signal
    return;
  }
  siglongjmp(*rescue, signal);
}

static void print(void *state, const char *text) {
  (void)state;
  fputs(text, stderr);
}

static void fail(void *state, const char *reason) {
  (void)state;
  snprintf(failure, sizeof failure, "%s", reason);
}

static void *no_variable(void *state, const char *group, const char *name, int *type) {
  (void)state;
  (void)group;
  (void)name;
  (void)type;
  return NULL;
}

static void set_rescue(void *buffer) {
  rescue = buffer;
}

static cf_library_host_t host CF_LIBRARY_KEEP = {.console      = print,
                                                 .fail         = fail,
                                                 .log_variable = no_variable,
                                                 .parameter    = no_variable,
                                                 .set_rescue   = set_rescue};

// For this thread and, as far as signals go, the whole process: not while others tick.
EXPORT void toy_watch(void);
void        toy_watch(void) {
  const stack_t    stack  = {.ss_sp = signal_stack, .ss_size = sizeof signal_stack};
  struct sigaction action = {.sa_flags = SA_ONSTACK | SA_NODEFER};
  action.sa_handler       = handle;
  sigemptyset(&action.sa_mask);
  sigaltstack(&stack, &old_stack);
  sigaction(SIGSEGV, &action, &old_action);
}

EXPORT void toy_watch_no_more(void);
void        toy_watch_no_more(void) {
  sigaction(SIGSEGV, &old_action, NULL);
  sigaltstack(&old_stack, NULL);
}

// Returns the size of a block.
EXPORT size_t toy_open(const cf_image_range_t *ranges, int n_ranges, const uint32_t *pointers,
                       int n_pointers);
size_t        toy_open(const cf_image_range_t *ranges, int n_ranges, const uint32_t *pointers,
                       int n_pointers) {
  map = (cf_image_map_t){ranges, n_ranges, pointers, n_pointers};
  cf_work_open(&host);
  return cf_image_open(&map) ? cf_image_bytes() : 0;
}

static void boot(void *state, int of_kind) {
  cf_work_enter_factory(state, "boot");
  kind = of_kind;
  cf_rtos_boot();
  numbers = xQueueCreate(4, sizeof(uint32_t));
  start_tasks();
  cf_work_leave(state);
}

EXPORT void toy_boot(void *state, int of_kind);
void        toy_boot(void *state, int of_kind) {
  boot(state, of_kind);
}

static void tick(uint32_t now) {
  cf_work_tell_time(now);
  cf_rtos_set_time(now);
  if (now % 2 == 0) {
    cf_rtos_signal_data_ready();
  }
  cf_rtos_run_ready();
}

// Returns why the drone failed, or nothing.
EXPORT const char *toy_tick(void *state, uint32_t now);
const char        *toy_tick(void *state, uint32_t now) {
  failure[0] = 0;
  cf_work_enter(state, "tick");
  const int signal = sigsetjmp(cf_work_rescue, 0);
  if (signal == 0) {
    cf_work_protect();
    tick(now);
    cf_work_leave(state);
  } else {
    cf_work_abandon(signal);
  }
  return failure;
}

EXPORT uint64_t toy_sum(const void *state);
uint64_t        toy_sum(const void *state) {
  cf_work_enter(state, "sum");
  const uint64_t result = sum;
  cf_work_leave_unchanged(state);
  return result;
}

EXPORT uint32_t toy_laps(const void *state);
uint32_t        toy_laps(const void *state) {
  cf_work_enter(state, "laps");
  const uint32_t result = laps;
  cf_work_leave_unchanged(state);
  return result;
}
