#include <string.h>

#include "bitcraze/rtos/scheduler.h"

#define POOL_QUEUES 16
#define POOL_BYTES 1024

// For queues and semaphores that bring no storage. What is deleted is not used again.
static StaticQueue_t pool[POOL_QUEUES];
static int           taken;
static uint64_t      pool_storage[POOL_BYTES / sizeof(uint64_t)];
static size_t        taken_words;

void cf_queues_boot(void) {
  memset(pool, 0, sizeof pool);
  memset(pool_storage, 0, sizeof pool_storage);
  taken       = 0;
  taken_words = 0;
}

static StaticQueue_t *from_pool(void) {
  if (taken == POOL_QUEUES) {
    cf_rtos_fail("no room for another queue or semaphore: %d were created without storage",
                 POOL_QUEUES);
  }
  return &pool[taken++];
}

static uint8_t *storage_from_pool(size_t bytes) {
  const size_t words = (bytes + sizeof(uint64_t) - 1) / sizeof(uint64_t);
  if (words > POOL_BYTES / sizeof(uint64_t) - taken_words) {
    cf_rtos_fail("no room for a queue of %zu bytes: %zu of %d are left for queues without storage",
                 bytes, POOL_BYTES - taken_words * sizeof(uint64_t), POOL_BYTES);
  }
  uint8_t *storage = (uint8_t *)(pool_storage + taken_words);
  taken_words += words;
  return storage;
}

// --------------------------------------------------------------------------------------- creation

QueueHandle_t xQueueCreateStatic(UBaseType_t length, UBaseType_t item_bytes, uint8_t *storage,
                                 StaticQueue_t *queue) {
  *queue = (StaticQueue_t){
      .storage = storage, .length = (uint32_t)length, .item_bytes = (uint32_t)item_bytes};
  return queue;
}

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t item_bytes) {
  StaticQueue_t *queue = from_pool();
  return xQueueCreateStatic(length, item_bytes, storage_from_pool(length * item_bytes), queue);
}

void vQueueDelete(QueueHandle_t queue) {
  (void)queue;
}

SemaphoreHandle_t xSemaphoreCreateCountingStatic(UBaseType_t most, UBaseType_t count,
                                                 StaticSemaphore_t *semaphore) {
  *semaphore = (StaticSemaphore_t){.length = (uint32_t)most, .count = (uint32_t)count};
  return semaphore;
}

SemaphoreHandle_t xSemaphoreCreateCounting(UBaseType_t most, UBaseType_t count) {
  return xSemaphoreCreateCountingStatic(most, count, from_pool());
}

SemaphoreHandle_t xSemaphoreCreateBinaryStatic(StaticSemaphore_t *semaphore) {
  return xSemaphoreCreateCountingStatic(1, 0, semaphore);
}

SemaphoreHandle_t xSemaphoreCreateBinary(void) {
  return xSemaphoreCreateBinaryStatic(from_pool());
}

SemaphoreHandle_t xSemaphoreCreateMutexStatic(StaticSemaphore_t *semaphore) {
  xSemaphoreCreateCountingStatic(1, 1, semaphore);
  semaphore->is_mutex = true;
  return semaphore;
}

SemaphoreHandle_t xSemaphoreCreateMutex(void) {
  return xSemaphoreCreateMutexStatic(from_pool());
}

// ---------------------------------------------------------------------------------------- waiting

static bool is_possible(const StaticQueue_t *queue, int what) {
  return what == CF_WAITS_ITEM ? queue->count > 0 : queue->count < queue->length;
}

// Waits for an item, or for space for one. Another task may take it first, hence the loop.
static bool wait_for(const StaticQueue_t *queue, int what, TickType_t wait) {
  if (!is_possible(queue, what) && cf_rtos_can_wait(wait)) {
    const cf_deadline_t deadline = cf_rtos_deadline(wait);
    while (cf_rtos_wait(queue, what, deadline) && !is_possible(queue, what)) {
    }
  }
  return is_possible(queue, what);
}

// ----------------------------------------------------------------------------------------- queues

static uint8_t *item_at(const StaticQueue_t *queue, uint32_t place) {
  return queue->storage + (size_t)((queue->head + place) % queue->length) * queue->item_bytes;
}

static void copy(void *to, const void *from, size_t bytes) {
  if (bytes > 0) {
    memcpy(to, from, bytes);
  }
}

static void append(StaticQueue_t *queue, const void *item) {
  copy(item_at(queue, queue->count), item, queue->item_bytes);
  queue->count++;
  cf_rtos_wake(queue, CF_WAITS_ITEM);
}

uint32_t cf_rtos_refused;

BaseType_t xQueueSendToBack(QueueHandle_t queue, const void *item, TickType_t wait) {
  if (!wait_for(queue, CF_WAITS_SPACE, wait)) {
    cf_rtos_refused++;
    return errQUEUE_FULL;
  }
  append(queue, item);
  return pdPASS;
}

BaseType_t xQueueSendToFront(QueueHandle_t queue, const void *item, TickType_t wait) {
  if (!wait_for(queue, CF_WAITS_SPACE, wait)) {
    return errQUEUE_FULL;
  }
  queue->head = (queue->head + queue->length - 1) % queue->length;
  copy(item_at(queue, 0), item, queue->item_bytes);
  queue->count++;
  cf_rtos_wake(queue, CF_WAITS_ITEM);
  return pdPASS;
}

BaseType_t xQueueOverwrite(QueueHandle_t queue, const void *item) {
  if (queue->count == queue->length) {
    // for queues of one item; of a longer one the newest is replaced
    queue->count--;
  }
  append(queue, item);
  return pdPASS;
}

BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t wait) {
  if (!wait_for(queue, CF_WAITS_ITEM, wait)) {
    return errQUEUE_EMPTY;
  }
  copy(item, item_at(queue, 0), queue->item_bytes);
  queue->head = (queue->head + 1) % queue->length;
  queue->count--;
  cf_rtos_wake(queue, CF_WAITS_SPACE);
  return pdPASS;
}

BaseType_t xQueuePeek(QueueHandle_t queue, void *item, TickType_t wait) {
  if (!wait_for(queue, CF_WAITS_ITEM, wait)) {
    return errQUEUE_EMPTY;
  }
  copy(item, item_at(queue, 0), queue->item_bytes);
  // the item stays in the queue: wake the next waiting task
  cf_rtos_wake(queue, CF_WAITS_ITEM);
  return pdPASS;
}

BaseType_t xQueueReset(QueueHandle_t queue) {
  queue->count = 0;
  queue->head  = 0;
  cf_rtos_wake(queue, CF_WAITS_SPACE);
  return pdPASS;
}

UBaseType_t uxQueueMessagesWaiting(QueueHandle_t queue) {
  return queue->count;
}

UBaseType_t uxQueueSpacesAvailable(QueueHandle_t queue) {
  return queue->length - queue->count;
}

// ------------------------------------------------------------------------------------- semaphores

// Code on the simulation's stack cannot block until a task gives a mutex back. Code that passes an
// infinite timeout may ignore the result of the take.
static void check_mutex(const StaticQueue_t *mutex, TickType_t wait) {
  const StaticTask_t *taker = xTaskGetCurrentTaskHandle();
  if (mutex->count > 0 || wait == 0) {
    return;
  }
  if (taker != NULL && mutex->holder == taker) {
    cf_rtos_fail("task '%s' waits for a mutex that it holds itself", taker->name);
  }
  if (taker == NULL) {
    cf_rtos_fail("a mutex is needed outside of tasks while %s%s%s holds it",
                 mutex->holder != NULL ? "task '" : "somebody",
                 mutex->holder != NULL ? mutex->holder->name : "",
                 mutex->holder != NULL ? "'" : "");
  }
}

BaseType_t xSemaphoreTake(SemaphoreHandle_t semaphore, TickType_t wait) {
  if (semaphore->is_mutex) {
    check_mutex(semaphore, wait);
  }
  if (!wait_for(semaphore, CF_WAITS_ITEM, wait)) {
    return pdFALSE;
  }
  semaphore->count--;
  semaphore->holder = semaphore->is_mutex ? xTaskGetCurrentTaskHandle() : NULL;
  return pdTRUE;
}

BaseType_t xSemaphoreGive(SemaphoreHandle_t semaphore) {
  if (semaphore->count == semaphore->length) {
    return pdFALSE;
  }
  semaphore->holder = NULL;
  semaphore->count++;
  cf_rtos_wake(semaphore, CF_WAITS_ITEM);
  return pdTRUE;
}

// ---------------------------------------------------------------------------------- of interrupts

BaseType_t xSemaphoreTakeFromISR(SemaphoreHandle_t semaphore, BaseType_t *woken) {
  (void)woken;
  return xSemaphoreTake(semaphore, 0);
}

BaseType_t xSemaphoreGiveFromISR(SemaphoreHandle_t semaphore, BaseType_t *woken) {
  (void)woken;
  return xSemaphoreGive(semaphore);
}

BaseType_t xQueueSendToBackFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken) {
  (void)woken;
  return xQueueSendToBack(queue, item, 0);
}

BaseType_t xQueueSendToFrontFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken) {
  (void)woken;
  return xQueueSendToFront(queue, item, 0);
}

BaseType_t xQueueOverwriteFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken) {
  (void)woken;
  return xQueueOverwrite(queue, item);
}

BaseType_t xQueueReceiveFromISR(QueueHandle_t queue, void *item, BaseType_t *woken) {
  (void)woken;
  return xQueueReceive(queue, item, 0);
}

BaseType_t xQueuePeekFromISR(QueueHandle_t queue, void *item) {
  return xQueuePeek(queue, item, 0);
}
