// Holds the one setpoint that is flown, and lets only its owner change it.
#include "commander.h"

#include <string.h>

#include "FreeRTOS.h"
#include "cf_math.h"
#include "crtp_commander.h"
#include "crtp_commander_high_level.h"
#include "param.h"
#include "queue.h"
#include "static_mem.h"
#include "task.h"

static bool             isInit;
static const setpoint_t nullSetpoint;
static const int        priorityDisable = COMMANDER_PRIORITY_DISABLE;
static state_t          lastState;
static uint32_t         lastUpdate;
static bool             enableHighLevel = false;

static QueueHandle_t setpointQueue;
STATIC_MEM_QUEUE_ALLOC(setpointQueue, 1, sizeof(setpoint_t));
static QueueHandle_t priorityQueue;
STATIC_MEM_QUEUE_ALLOC(priorityQueue, 1, sizeof(int));

void commanderInit(void) {
  setpointQueue = STATIC_MEM_QUEUE_CREATE(setpointQueue);
  ASSERT(setpointQueue);
  xQueueSend(setpointQueue, &nullSetpoint, 0);

  priorityQueue = STATIC_MEM_QUEUE_CREATE(priorityQueue);
  ASSERT(priorityQueue);
  xQueueSend(priorityQueue, &priorityDisable, 0);

  crtpCommanderInit();
  crtpCommanderHighLevelInit();
  lastUpdate = xTaskGetTickCount();
  isInit     = true;
}

void commanderSetSetpoint(setpoint_t *setpoint, int priority) {
  int currentPriority;
  xQueuePeek(priorityQueue, &currentPriority, 0);
  if (priority < currentPriority) {
    return;
  }
  setpoint->timestamp = xTaskGetTickCount();
  xQueueOverwrite(setpointQueue, setpoint);
  xQueueOverwrite(priorityQueue, &priority);
  if (priority > COMMANDER_PRIORITY_HIGHLEVEL) {
    crtpCommanderHighLevelStop();
  }
}

void commanderRelaxPriority(void) {
  const int lowest = COMMANDER_PRIORITY_LOWEST;
  crtpCommanderHighLevelTellState(&lastState);
  xQueueOverwrite(priorityQueue, &lowest);
}

void commanderGetSetpoint(setpoint_t *setpoint, const state_t *state) {
  xQueuePeek(setpointQueue, setpoint, 0);
  lastUpdate = setpoint->timestamp;
  // for plans that begin when the priority is relaxed
  lastState = *state;
}

bool commanderTest(void) {
  return isInit;
}

uint32_t commanderGetInactivityTime(void) {
  return xTaskGetTickCount() - lastUpdate;
}

int commanderGetActivePriority(void) {
  int priority;
  xQueuePeek(priorityQueue, &priority, 0);
  return priority;
}

PARAM_GROUP_START(commander)
// has no effect any more
PARAM_ADD_CORE(PARAM_UINT8, enHighLevel, &enableHighLevel)
PARAM_GROUP_STOP(commander)
