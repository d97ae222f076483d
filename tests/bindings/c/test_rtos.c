/* The shim of FreeRTOS that the firmware's tasks run on: order of tasks, and results of waits. */
#define _GNU_SOURCE  // sigsetjmp
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include "FreeRTOS.h"
#include "bitcraze/rtos/coroutine.h"
#include "bitcraze/rtos/hardware.h"
#include "bitcraze/rtos/kernel.h"
#include "check.h"
#include "event_groups.h"
#include "library/inner.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"
#include "timers.h"

// ------------------------------------------------------------------------- in place of a library

static sigjmp_buf way_out;
static char       reason[256];

void cf_library_fail(const char *why) {
  snprintf(reason, sizeof reason, "%s", why);
  siglongjmp(way_out, 1);
}

// What was seen, one letter each.
static char story[4096];
static int  told;

static void tell(char letter) {
  CHECK(told < (int)sizeof story - 1);
  story[told++] = letter;
  story[told]   = 0;
}

static void forget(void) {
  told     = 0;
  story[0] = 0;
}

static void boot(void) {
  cf_rtos_boot();
  forget();
}

static void tick(uint32_t now) {
  cf_rtos_set_time(now);
  cf_rtos_run_ready();
}

static void ticks(uint32_t first, uint32_t last) {
  for (uint32_t now = first; now <= last; now++) {
    tick(now);
    tell('.');
  }
}

#define EXPECT_FAILURE(text_, ...)       \
  do {                                   \
    if (sigsetjmp(way_out, 0) == 0) {    \
      __VA_ARGS__;                       \
      CHECK(!"must fail");               \
    }                                    \
    if (strcmp(reason, text_) != 0) {    \
      fprintf(stderr, "'%s'\n", reason); \
    }                                    \
    CHECK(strcmp(reason, text_) == 0);   \
  } while (0)

#define EXPECT_STORY(text_)             \
  do {                                  \
    if (strcmp(story, text_) != 0) {    \
      fprintf(stderr, "'%s'\n", story); \
    }                                   \
    CHECK(strcmp(story, text_) == 0);   \
  } while (0)

static StaticTask_t places[CF_STACKS];
static int          n_places;

static TaskHandle_t create(TaskFunction_t entry, const char *name, UBaseType_t priority,
                           void *argument) {
  return xTaskCreateStatic(entry, name, 100, argument, priority, NULL,
                           &places[n_places++ % CF_STACKS]);
}

// ---------------------------------------------------------------------------------------- delays

static void delays(void *letter) {
  for (;;) {
    tell(*(const char *)letter);
    vTaskDelay(2);
  }
}

static void delays_until(void *letter) {
  TickType_t last = xTaskGetTickCount();
  for (;;) {
    tell(*(const char *)letter);
    vTaskDelayUntil(&last, 3);
  }
}

static void test_delays(void) {
  boot();
  create(delays, "A", 1, "a");
  create(delays_until, "B", 1, "b");
  CHECK(cf_rtos_task_count() == 2);
  CHECK(strcmp(cf_rtos_task_name(1), "B") == 0);
  CHECK(cf_rtos_task_name(2) == NULL);
  ticks(10, 16);
  EXPECT_STORY("ab..a.b.a..ab.");
}

static void test_delays_across_the_wrap_of_the_clock(void) {
  boot();
  cf_rtos_set_time(0xfffffffeu);
  create(delays_until, "B", 1, "b");
  for (uint32_t i = 0; i < 7; i++) {
    tick(0xfffffffeu + i);
    tell('.');
  }
  EXPECT_STORY("b...b...b.");
}

static void late(void *unused) {
  (void)unused;
  TickType_t last = xTaskGetTickCount();
  vTaskDelay(5);
  // behind by two periods of two ticks, and then in time
  CHECK(xTaskDelayUntil(&last, 2) == pdFALSE);
  CHECK(xTaskDelayUntil(&last, 2) == pdFALSE);
  CHECK(xTaskDelayUntil(&last, 2) == pdTRUE);
  CHECK(xTaskGetTickCount() == 6);
  tell('x');
}

static void test_who_is_late_does_not_wait(void) {
  boot();
  create(late, "LATE", 1, NULL);
  ticks(0, 7);
  EXPECT_STORY("......x..");
}

static void test_outside_of_tasks_nothing_waits(void) {
  boot();
  uint8_t       item = 1, storage[1];
  StaticQueue_t queue;
  xQueueCreateStatic(1, 1, storage, &queue);
  CHECK(!cf_rtos_is_in_task());
  vTaskDelay(5);
  TickType_t last = 0;
  vTaskDelayUntil(&last, 7);
  CHECK(last == 7);
  taskYIELD();
  CHECK(xQueueReceive(&queue, &item, portMAX_DELAY) == pdFALSE);
  CHECK(xQueueSend(&queue, &item, portMAX_DELAY) == pdTRUE);
  CHECK(xQueueSend(&queue, &item, portMAX_DELAY) == errQUEUE_FULL);
  CHECK(ulTaskNotifyTake(pdTRUE, 5) == 0);
  CHECK(xTaskGetCurrentTaskHandle() == NULL);
  cf_rtos_wait_data_ready();
}

// --------------------------------------------------------------------------- order, ping and pong

static SemaphoreHandle_t ping, pong;

static void pings(void *unused) {
  (void)unused;
  for (int i = 0; i < 3; i++) {
    tell('i');
    CHECK(xSemaphoreGive(ping) == pdTRUE);
    CHECK(xSemaphoreTake(pong, portMAX_DELAY) == pdTRUE);
  }
  tell('I');
}

static void pongs(void *unused) {
  (void)unused;
  for (;;) {
    CHECK(xSemaphoreTake(ping, portMAX_DELAY) == pdTRUE);
    tell('o');
    // gives to a higher priority, and goes on
    CHECK(xSemaphoreGive(pong) == pdTRUE);
    tell('O');
  }
}

static void test_ping_pong(void) {
  boot();
  ping = xSemaphoreCreateBinary();
  pong = xSemaphoreCreateBinary();
  create(pings, "PING", 3, NULL);
  create(pongs, "PONG", 1, NULL);
  ticks(1, 2);
  EXPECT_STORY("ioOioOioOI..");
}

static void once(void *letter) {
  tell(*(const char *)letter);
}

static void yields(void *letter) {
  for (int i = 0; i < 3; i++) {
    tell(*(const char *)letter);
    taskYIELD();
  }
}

static void test_priorities_and_then_who_came_first(void) {
  boot();
  create(once, "A", 1, "a");
  create(once, "B", 5, "b");
  create(yields, "C", 2, "c");
  create(yields, "D", 2, "d");
  create(once, "E", 5, "e");
  ticks(1, 1);
  EXPECT_STORY("becdcdcda.");
}

static void changes(void *other) {
  tell('x');
  vTaskPrioritySet(other, 7);
  CHECK(uxTaskPriorityGet(other) == 7 && uxTaskPriorityGet(NULL) == 9);
}

static void test_a_priority_is_changed(void) {
  boot();
  create(once, "A", 1, "a");
  create(changes, "X", 9, create(once, "B", 0, "b"));
  ticks(1, 1);
  EXPECT_STORY("xba.");
}

// ---------------------------------------------------------------------------------------- queues

static QueueHandle_t queue;

static void receives(void *letter) {
  for (;;) {
    uint32_t item = 0;
    if (xQueueReceive(queue, &item, 3) == pdTRUE) {
      tell((char)item);
    } else {
      tell(*(const char *)letter);
    }
  }
}

static void send(uint32_t item) {
  CHECK(xQueueSendFromISR(queue, &item, NULL) == pdTRUE);
}

static void test_a_queue_keeps_the_order_and_waits_end_in_time(void) {
  static StaticQueue_t place;
  static uint8_t       storage[3 * sizeof(uint32_t)];
  boot();
  queue = xQueueCreateStatic(3, sizeof(uint32_t), storage, &place);
  create(receives, "R", 1, "-");
  ticks(1, 2);
  send('1');
  send('2');
  const uint32_t front = '0';
  CHECK(xQueueSendToFront(queue, &front, 0) == pdTRUE);
  CHECK(xQueueSendToFront(queue, &front, 0) == errQUEUE_FULL);
  CHECK(uxQueueMessagesWaiting(queue) == 3 && uxQueueSpacesAvailable(queue) == 0);
  ticks(3, 10);
  EXPECT_STORY("..012...-...-..");
  send('9');
  send('9');
  CHECK(xQueueReset(queue) == pdPASS && uxQueueMessagesWaiting(queue) == 0);
}

static void sends(void *unused) {
  (void)unused;
  for (uint32_t item = 'a'; item <= 'e'; item++) {
    tell(xQueueSend(queue, &item, 2) == pdTRUE ? '+' : '-');
  }
}

static void test_a_full_queue_makes_the_sender_wait(void) {
  boot();
  queue = xQueueCreate(2, sizeof(uint32_t));
  create(sends, "S", 1, NULL);
  ticks(1, 1);
  uint32_t item;
  CHECK(xQueuePeek(queue, &item, 0) == pdTRUE && item == 'a');
  CHECK(xQueueReceive(queue, &item, 0) == pdTRUE && item == 'a');
  ticks(2, 5);
  EXPECT_STORY("++.+..-..");
  CHECK(xQueueReceiveFromISR(queue, &item, NULL) == pdTRUE && item == 'b');
  CHECK(xQueueReceive(queue, &item, 0) == pdTRUE && item == 'c');
  CHECK(xQueueReceive(queue, &item, 0) == pdFALSE);
  ticks(6, 6);
  EXPECT_STORY("++.+..-..+.");
  CHECK(xQueuePeekFromISR(queue, &item) == pdTRUE && item == 'e');
}

static void test_the_newest_of_a_queue_of_one(void) {
  boot();
  queue = xQueueCreate(1, sizeof(uint32_t));
  uint32_t item;
  for (uint32_t i = 0; i < 3; i++) {
    CHECK(xQueueOverwrite(queue, &i) == pdPASS);
    CHECK(xQueuePeek(queue, &item, 0) == pdTRUE && item == i);
  }
  CHECK(uxQueueMessagesWaiting(queue) == 1);
}

static void peeks(void *letter) {
  uint32_t item;
  CHECK(xQueuePeek(queue, &item, portMAX_DELAY) == pdTRUE);
  tell(*(const char *)letter);
}

static void test_all_who_wait_to_look_see_an_item(void) {
  boot();
  queue = xQueueCreate(1, sizeof(uint32_t));
  create(peeks, "A", 1, "a");
  create(peeks, "B", 2, "b");
  create(receives, "R", 0, "-");
  ticks(1, 1);
  send('x');
  ticks(2, 2);
  EXPECT_STORY(".bax.");
}

// ------------------------------------------------------------------------------------- semaphores

static void takes(void *letter) {
  for (;;) {
    xSemaphoreTake(ping, portMAX_DELAY);
    tell(*(const char *)letter);
  }
}

static void test_semaphores_saturate(void) {
  static StaticSemaphore_t place;
  boot();
  ping = xSemaphoreCreateBinaryStatic(&place);
  CHECK(xSemaphoreTake(ping, 0) == pdFALSE);
  CHECK(xSemaphoreGive(ping) == pdTRUE && xSemaphoreGive(ping) == pdFALSE);
  CHECK(xSemaphoreTake(ping, 0) == pdTRUE && xSemaphoreTake(ping, 0) == pdFALSE);
  BaseType_t woken = pdFALSE;
  CHECK(xSemaphoreGiveFromISR(ping, &woken) == pdTRUE && woken == pdFALSE);
  create(takes, "A", 1, "a");
  create(takes, "B", 2, "b");
  ticks(1, 1);
  xSemaphoreGive(ping);
  ticks(2, 3);
  EXPECT_STORY("b.b..");
  pong = xSemaphoreCreateCounting(3, 2);
  CHECK(xSemaphoreGive(pong) == pdTRUE && xSemaphoreGive(pong) == pdFALSE);
  CHECK(uxSemaphoreGetCount(pong) == 3);
  SemaphoreHandle_t full;
  vSemaphoreCreateBinary(full);
  CHECK(xSemaphoreTakeFromISR(full, &woken) == pdTRUE);
}

static SemaphoreHandle_t mutex;

static void holds(void *unused) {
  (void)unused;
  CHECK(xSemaphoreTake(mutex, portMAX_DELAY) == pdTRUE);
  tell('h');
  vTaskDelay(3);
  tell('H');
  CHECK(xSemaphoreGive(mutex) == pdTRUE);
}

static void wants(void *unused) {
  (void)unused;
  CHECK(xSemaphoreTake(mutex, 0) == pdFALSE);
  CHECK(xSemaphoreTake(mutex, portMAX_DELAY) == pdTRUE);
  tell('w');
  CHECK(xSemaphoreGive(mutex) == pdTRUE);
}

static void holds_and_waits(void *unused) {
  (void)unused;
  xSemaphoreTake(mutex, portMAX_DELAY);
  xSemaphoreTake(mutex, portMAX_DELAY);
}

static void test_a_mutex(void) {
  boot();
  mutex = xSemaphoreCreateMutex();
  CHECK(xSemaphoreTake(mutex, portMAX_DELAY) == pdTRUE);
  CHECK(xSemaphoreGive(mutex) == pdTRUE && xSemaphoreGive(mutex) == pdFALSE);
  create(holds, "HOLDER", 2, NULL);
  create(wants, "WANTS", 1, NULL);
  ticks(1, 2);
  CHECK(xSemaphoreTake(mutex, 0) == pdFALSE);
  EXPECT_FAILURE("a mutex is needed outside of tasks while task 'HOLDER' holds it",
                 xSemaphoreTake(mutex, portMAX_DELAY));
  ticks(3, 5);
  EXPECT_STORY("h...Hw..");
  create(holds_and_waits, "TWICE", 1, NULL);
  EXPECT_FAILURE("task 'TWICE' waits for a mutex that it holds itself", tick(6));
}

// --------------------------------------------------------------------- notifications and events

static void notified(void *clears) {
  for (;;) {
    const uint32_t count = ulTaskNotifyTake(clears != NULL, 4);
    tell((char)('0' + count));
  }
}

static void test_notifications(void) {
  boot();
  TaskHandle_t all  = create(notified, "ALL", 2, "yes");
  TaskHandle_t each = create(notified, "EACH", 1, NULL);
  ticks(1, 2);
  for (int i = 0; i < 3; i++) {
    vTaskNotifyGiveFromISR(all, NULL);
    xTaskNotifyGive(each);
  }
  ticks(3, 7);
  EXPECT_STORY("..3321....00.");
}

static EventGroupHandle_t group;

static void awaits_any(void *unused) {
  (void)unused;
  const EventBits_t bits = xEventGroupWaitBits(group, 0x3, pdTRUE, pdFALSE, portMAX_DELAY);
  tell((char)('0' + bits));
}

static void awaits_all(void *unused) {
  (void)unused;
  tell((char)('0' + xEventGroupWaitBits(group, 0x6, pdFALSE, pdTRUE, 2)));
  tell((char)('0' + xEventGroupWaitBits(group, 0x6, pdFALSE, pdTRUE, portMAX_DELAY)));
}

static void test_events(void) {
  boot();
  group = xEventGroupCreate();
  create(awaits_any, "ANY", 1, NULL);
  create(awaits_all, "ALL", 2, NULL);
  ticks(1, 1);
  CHECK(xEventGroupSetBits(group, 0x4) == 0x4);
  ticks(2, 3);
  // both tasks get both bits, and one of them clears the bit of its own wait
  CHECK(xEventGroupSetBits(group, 0x2) == 0x4);
  ticks(4, 4);
  EXPECT_STORY("..4.66.");
  CHECK(xEventGroupClearBits(group, 0x4) == 0x4 && xEventGroupGetBits(group) == 0);
}

// ----------------------------------------------------------------------------------------- timers

static void calls(TimerHandle_t timer) {
  CHECK(!cf_rtos_is_in_task());
  tell(*(const char *)pvTimerGetTimerID(timer));
  if (ping != NULL) {
    xSemaphoreGive(ping);
  }
}

static void test_timers_are_called_after_the_tasks(void) {
  static StaticTimer_t place;
  boot();
  ping               = NULL;
  TimerHandle_t slow = xTimerCreateStatic("SLOW", 4, pdTRUE, "s", calls, &place);
  TimerHandle_t fast = xTimerCreate("FAST", 2, pdTRUE, "f", calls);
  TimerHandle_t shot = xTimerCreate("SHOT", 4, pdFALSE, "x", calls);
  create(delays, "A", 1, "a");
  CHECK(!xTimerIsTimerActive(fast));
  xTimerStart(fast, 0);
  xTimerStart(shot, 0);
  xTimerStart(slow, 0);
  ticks(1, 5);
  EXPECT_STORY("a.f.a.sfx.a.");
  CHECK(!xTimerIsTimerActive(shot) && xTimerIsTimerActive(slow));
  xTimerStop(slow, 0);
  xTimerChangePeriod(fast, 2, 0);
  forget();
  ticks(6, 8);
  EXPECT_STORY(".af..");
  EXPECT_FAILURE("timer 'SLOW' is created a second time",
                 xTimerCreateStatic("S", 4, pdTRUE, NULL, calls, &place));
}

static void test_tasks_that_a_timer_wakes_run_in_the_same_tick(void) {
  boot();
  ping = xSemaphoreCreateBinary();
  create(takes, "T", 1, "t");
  xTimerStart(xTimerCreate("ONE", 2, pdTRUE, "s", calls), 0);
  ticks(1, 4);
  EXPECT_STORY(".st..st.");
}

// ------------------------------------------------------------------------- the beat of the sensors

static void flies(void *unused) {
  (void)unused;
  for (uint32_t step = 1;; step++) {
    cf_rtos_wait_data_ready();
    tell((char)('0' + step));
  }
}

static void test_the_beat_of_the_sensors(void) {
  boot();
  create(flies, "STABILIZER", 5, NULL);
  for (uint32_t now = 1; now <= 3; now++) {
    cf_rtos_signal_data_ready();
    ticks(now, now);
  }
  ticks(4, 5);
  EXPECT_STORY("1.2.3...");
}

// ------------------------------------------------------------------- suspended, deleted, too many

static void test_tasks_are_stopped_and_go_on(void) {
  boot();
  TaskHandle_t a = create(delays, "A", 1, "a");
  TaskHandle_t b = create(delays, "B", 1, "b");
  ticks(1, 1);
  vTaskSuspend(a);
  vTaskDelete(b);
  ticks(2, 5);
  vTaskResume(a);
  vTaskResume(b);
  ticks(6, 8);
  EXPECT_STORY("ab.....a..a.");
}

static void test_no_more_tasks_than_there_are_places(void) {
  boot();
  for (int i = 0; i < CF_STACKS; i++) {
    TaskHandle_t task = NULL;
    CHECK(xTaskCreate(once, "SOME", 100, "s", 0, &task) == pdPASS && task != NULL);
  }
  EXPECT_FAILURE("no place for task 'NINTH': there are 8 already",
                 xTaskCreate(once, "NINTH", 100, "n", 0, NULL));
  ticks(1, 2);
  EXPECT_STORY("ssssssss..");
  boot();
  static StaticTask_t place;
  xTaskCreateStatic(once, "FIRST", 1, "1", 0, NULL, &place);
  EXPECT_FAILURE("task 'SECOND' is created in the place of task 'FIRST'",
                 xTaskCreateStatic(once, "SECOND", 1, "1", 0, NULL, &place));
}

static void test_what_is_created_without_storage_is_limited(void) {
  boot();
  for (int i = 0; i < 16; i++) {
    xSemaphoreCreateBinary();
  }
  EXPECT_FAILURE("no room for another queue or semaphore: 16 were created without storage",
                 xSemaphoreCreateMutex());
  boot();
  xQueueCreate(10, 100);
  EXPECT_FAILURE("no room for a queue of 30 bytes: 24 of 1024 are left for queues without storage",
                 xQueueCreate(1, 30));
}

// ----------------------------------------------------------------------------------------- failure

static void never_waits(void *unused) {
  (void)unused;
  for (;;) {
    vTaskDelay(0);
  }
}

static void test_a_task_that_never_waits_is_named(void) {
  boot();
  create(never_waits, "BUSY", 1, NULL);
  EXPECT_FAILURE("task 'BUSY' does not come to wait: 1000 turns within one tick", tick(1));
}

static volatile char sink;

static void waits_with(size_t bytes) {
  volatile char room[bytes];
  memset((void *)(uintptr_t)room, 1, bytes);
  vTaskDelay(1);
  sink = room[bytes / 2];
}

static void waits_with_much(void *unused) {
  (void)unused;
  tell('a');
  waits_with(1500);
  tell('b');
  waits_with(100);
  tell('c');
  waits_with(5000);
  tell('d');
}

static void test_what_a_waiting_task_may_use_is_limited(void) {
  boot();
  create(delays, "FIRST", 1, "1");
  create(waits_with_much, "MUCH", 1, NULL);
  create(delays, "THIRD", 1, "3");
  ticks(1, 2);
  EXPECT_STORY("1a3.b.");
  if (sigsetjmp(way_out, 0) == 0) {
    tick(3);
    CHECK(!"must fail");
  }
  CHECK(strncmp(reason, "task 'MUCH' waits with 5", 24) == 0);
  CHECK(strstr(reason, " bytes on its stack, allowed: 4096") != NULL);
}

static void waits_with_1500(void *unused) {
  (void)unused;
  waits_with(1500);
}

static void test_what_all_together_may_use_is_limited(void) {
  boot();
  for (int i = 0; i < 4; i++) {
    create(waits_with_1500, i < 3 ? "SOME" : "LAST", 1, NULL);
  }
  if (sigsetjmp(way_out, 0) == 0) {
    tick(1);
    CHECK(!"must fail");
  }
  CHECK(strncmp(reason, "task 'LAST' waits with 1", 24) == 0);
  CHECK(strstr(reason, "with those of the other tasks; allowed: 6144") != NULL);
}

// Overwrites the canary, above the guard page.
static void overflows(void *unused) {
  (void)unused;
  extern uint64_t cf_stacks[CF_STACKS][CF_STACK_BYTES / 8];
  cf_stacks[cf_coroutine_number()][4096 / 8 + 3] = 1;
  vTaskDelay(1);
}

static void test_a_stack_that_overflows_is_noticed(void) {
  boot();
  create(overflows, "DEEP", 1, NULL);
  EXPECT_FAILURE("stack of task 'DEEP' overflowed (65536 bytes)", tick(1));
  // the next task starts with an intact stack
  boot();
  create(delays, "A", 1, "a");
  ticks(1, 3);
  EXPECT_STORY("a..a.");
}

static void fails(void *unused) {
  (void)unused;
  vTaskDelay(2);
  cf_library_fail("assertion failed");
}

static void test_after_a_failure_in_a_task_the_next_drone_flies(void) {
  for (volatile int i = 0; i < 3; i++) {
    boot();
    create(fails, "BAD", 2, NULL);
    create(delays, "A", 1, "a");
    ticks(1, 2);
    EXPECT_STORY("a..");
    EXPECT_FAILURE("assertion failed", tick(3));
    CHECK(!cf_rtos_is_in_task());
    cf_rtos_abandon();
    boot();
    create(delays, "A", 1, "a");
    ticks(1, 3);
    EXPECT_STORY("a..a.");
  }
}

// ---------------------------------------------------------------------------------------- hardware

void motorsSetRatio(uint32_t id, uint16_t ratio);
int  motorsGetRatio(uint32_t id);
void motorsStop(void);

static void test_motors_keep_what_they_were_told(void) {
  motorsSetRatio(2, 40000);
  motorsSetRatio(4, 1);
  CHECK(cf_hardware_motors[2] == 40000 && motorsGetRatio(2) == 40000 && motorsGetRatio(4) == 0);
  motorsStop();
  CHECK(motorsGetRatio(2) == 0);
}

int main(void) {
  test_delays();
  test_delays_across_the_wrap_of_the_clock();
  test_who_is_late_does_not_wait();
  test_outside_of_tasks_nothing_waits();
  test_ping_pong();
  test_priorities_and_then_who_came_first();
  test_a_priority_is_changed();
  test_a_queue_keeps_the_order_and_waits_end_in_time();
  test_a_full_queue_makes_the_sender_wait();
  test_the_newest_of_a_queue_of_one();
  test_all_who_wait_to_look_see_an_item();
  test_semaphores_saturate();
  test_a_mutex();
  test_notifications();
  test_events();
  test_timers_are_called_after_the_tasks();
  test_tasks_that_a_timer_wakes_run_in_the_same_tick();
  test_the_beat_of_the_sensors();
  test_tasks_are_stopped_and_go_on();
  test_no_more_tasks_than_there_are_places();
  test_what_is_created_without_storage_is_limited();
  test_a_task_that_never_waits_is_named();
  test_what_a_waiting_task_may_use_is_limited();
  test_what_all_together_may_use_is_limited();
  test_a_stack_that_overflows_is_noticed();
  test_after_a_failure_in_a_task_the_next_drone_flies();
  test_motors_keep_what_they_were_told();
  return 0;
}
