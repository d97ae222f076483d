// The stock PID under two functions with the same code, and a client of the tables.
#include <stdbool.h>
#include <string.h>

#include "controller.h"
#include "controller_pid.h"
#include "estimator.h"
#include "log.h"
#include "param.h"

#define DEBUG_MODULE "ASKING"
#include "debug.h"

static uint8_t  is_param_found;
static uint8_t  is_param_named;
static uint8_t  is_log_named;
static uint32_t calls;

static void ask(void) {
  char              *group = NULL;
  char              *name  = NULL;
  const paramVarId_t id    = paramGetVarIdFromComplete("pid_rate.roll_kp");
  is_param_found           = PARAM_VARID_IS_VALID(id) && paramGetFloat(id) > 1.0f;
  paramGetGroupAndName(id, &group, &name);
  is_param_named = strcmp(group, "pid_rate") == 0 && strcmp(name, "roll_kp") == 0;
  logGetGroupAndName(logGetVarId("asking", "calls"), &group, &name);
  is_log_named = strcmp(group, "asking") == 0 && strcmp(name, "calls") == 0;
  DEBUG_PRINT("asked\n");
}

void controllerOutOfTreeInit(void) {
  controllerPidInit();
}

bool controllerOutOfTreeTest(void) {
  return true;
}

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) {
  if (calls++ == 0) {
    ask();
  }
  controllerPid(control, setpoint, sensors, state, stabilizerStep);
}

void estimatorOutOfTreeInit(void) {
}

bool estimatorOutOfTreeTest(void) {
  return true;
}

void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep) {
  (void)stabilizerStep;
  measurement_t measurement;
  while (estimatorDequeue(&measurement)) {
    if (measurement.type == MeasurementTypePose) {
      state->position.z = measurement.data.pose.z;
    }
  }
}

LOG_GROUP_START(asking)
LOG_ADD(LOG_UINT8, paramFound, &is_param_found)
LOG_ADD(LOG_UINT8, paramNamed, &is_param_named)
LOG_ADD(LOG_UINT8, logNamed, &is_log_named)
LOG_ADD(LOG_UINT32, calls, &calls)
LOG_GROUP_STOP(asking)
