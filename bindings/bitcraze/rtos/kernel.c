#include "bitcraze/rtos/kernel.h"

#include "bitcraze/rtos/coroutine.h"
#include "bitcraze/rtos/scheduler.h"

static StaticSemaphore_t data_ready;

void cf_rtos_boot(void) {
  cf_rtos_abandon();
  cf_scheduler_boot();
  cf_tasks_boot();
  cf_timers_boot();
  cf_queues_boot();
  cf_events_boot();
  xSemaphoreCreateBinaryStatic(&data_ready);
}

void cf_rtos_run_ready(void) {
  if (cf_rtos_is_in_task()) {
    return;
  }
  cf_rtos_abandon();
  int turns = 0;
  do {
    cf_scheduler_run(&turns);
  } while (cf_timers_run());
}

void cf_rtos_abandon(void) {
  cf_coroutine_abandon();
}

void cf_rtos_wait_data_ready(void) {
  xSemaphoreTake(&data_ready, portMAX_DELAY);
}

void cf_rtos_signal_data_ready(void) {
  xSemaphoreGive(&data_ready);
}
