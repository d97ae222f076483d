// The stock PID, until a client asks it to write to nowhere.
#include "controller.h"
#include "controller_pid.h"
#include "param.h"

static uint8_t now;
static int    *nowhere;

void controllerOutOfTreeInit(void) {
  controllerPidInit();
}

bool controllerOutOfTreeTest(void) {
  return true;
}

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) {
  controllerPid(control, setpoint, sensors, state, stabilizerStep);
  if (now) {
    *nowhere = 1;
  }
}

PARAM_GROUP_START(crash)
PARAM_ADD(PARAM_UINT8, now, &now)
PARAM_GROUP_STOP(crash)
