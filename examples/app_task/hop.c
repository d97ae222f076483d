/* An app with a task of its own: takes off when it may, draws a square, and lands. No client is
 * needed. Flash it as an app of the firmware, or fly it here over a checkout. */
#define DEBUG_MODULE "HOP"

#include <stdbool.h>

#include "FreeRTOS.h"
#include "task.h"

#include "app.h"
#include "crtp_commander_high_level.h"
#include "debug.h"
#include "log.h"
#include "param.h"
#include "supervisor.h"

#define SIDE 0.4f      // [m]
#define DURATION 1.5f  // [s], of every part

static float   height = 0.5f;  // [m], parameter
static uint8_t corner;         // log variable

static const float CORNERS[][2] = {{SIDE, 0.0f}, {0.0f, SIDE}, {-SIDE, 0.0f}, {0.0f, -SIDE}};

void appMain(void) {
  DEBUG_PRINT("waiting for the supervisor\n");
  while (!supervisorCanFly()) {
    vTaskDelay(M2T(100));
  }
  vTaskDelay(M2T(1000));

  crtpCommanderHighLevelTakeoff(height, DURATION);
  vTaskDelay(M2T(2000));
  for (corner = 0; corner < 4; corner++) {
    crtpCommanderHighLevelGoTo(CORNERS[corner][0], CORNERS[corner][1], 0.0f, 0.0f, DURATION, true);
    vTaskDelay(M2T(1800));
  }
  crtpCommanderHighLevelLand(0.0f, DURATION);
  vTaskDelay(M2T(2000));
  DEBUG_PRINT("done after %d corners\n", corner);
}

PARAM_GROUP_START(hop)
PARAM_ADD(PARAM_FLOAT, height, &height)
PARAM_GROUP_STOP(hop)

LOG_GROUP_START(hop)
LOG_ADD(LOG_UINT8, corner, &corner)
LOG_GROUP_STOP(hop)
