// Runs a user's application in a task of its own.
#include "autoconf.h"

// clang-format off
#include "FreeRTOS.h"
#include "task.h"
#include "system.h"
#include "static_mem.h"
#include "app.h"
// clang-format on

#ifndef CONFIG_APP_STACKSIZE
#define CONFIG_APP_STACKSIZE 300
#endif
#ifndef CONFIG_APP_PRIORITY
#define CONFIG_APP_PRIORITY 0
#endif

static bool isInit = false;

STATIC_MEM_TASK_ALLOC(appTask, CONFIG_APP_STACKSIZE);

static void appTask(void *param);

void __attribute__((weak)) appInit() {
  if (isInit) {
    return;
  }
  STATIC_MEM_TASK_CREATE(appTask, appTask, "APP", NULL, CONFIG_APP_PRIORITY);
  isInit = true;
}

static void appTask(void *param) {
  (void)param;
  systemWaitStart();
  appMain();
  while (true) {
    // it has nothing more to do
    vTaskDelay(portMAX_DELAY);
  }
}
