// Prints, in parts and in lines too long.

#include "FreeRTOS.h"
#include "app_modes.h"
#include "task.h"
#include "usec_time.h"
#define DEBUG_MODULE "TESTAPP"
#include "debug.h"

void print(const call_t *call) {
  DEBUG_PRINT("step %u ", (unsigned)call->step);
  consolePrintf("at %u ms, %u us\n", (unsigned)xTaskGetTickCount(), (unsigned)usecTimestamp());
  vTaskDelay(M2T(1000));
}
