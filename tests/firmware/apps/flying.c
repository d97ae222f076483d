// Flies by itself: waits until it may, takes off, and tells what it sees.
#include "FreeRTOS.h"
#include "app.h"
#include "crtp_commander_high_level.h"
#include "log.h"
#include "param.h"
#include "task.h"

#define DEBUG_MODULE "FLYING"
#include "debug.h"

static uint8_t  wanted = 1;
static uint32_t turns;
static float    seen;

void appMain(void) {
  DEBUG_PRINT("hello\n");
  const logVarId_t   height   = logGetVarId("stateEstimate", "z");
  const paramVarId_t velocity = paramGetVarId("hlCommander", "vland");
  paramSetFloat(velocity, 0.25f);
  vTaskDelay(M2T(2500));
  if (wanted) {
    crtpCommanderHighLevelTakeoff(0.4f, 1.5f);
  }
  while (true) {
    vTaskDelay(M2T(10));
    seen = logGetFloat(height);
    turns++;
    if (turns == 250) {
      DEBUG_PRINT("at %d mm\n", (int)(seen * 1000.0f));
      crtpCommanderHighLevelLand(0.0f, 1.5f);
    }
  }
}

PARAM_GROUP_START(flying)
PARAM_ADD(PARAM_UINT8, wanted, &wanted)
PARAM_GROUP_STOP(flying)

LOG_GROUP_START(flying)
LOG_ADD(LOG_UINT32, turns, &turns)
LOG_ADD(LOG_FLOAT, seen, &seen)
LOG_GROUP_STOP(flying)
