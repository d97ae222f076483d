// The stock PID with something to remember: counts its calls in every kind of static variable.
#define DEBUG_MODULE "COUNT"
#include "controller.h"
#include "controller_pid.h"
#include "debug.h"
#include "log.h"
#include "param.h"

static uint32_t calls;
static uint32_t *volatile same = &calls;  // a pointer into the state
static float scale             = 1.0f;
static float thrust;
uint32_t     inits;  // global, as sloppy code has it

void controllerOutOfTreeInit(void) {
  controllerPidInit();
  inits++;
  DEBUG_PRINT("started %u times\n", (unsigned int)inits);
}

bool controllerOutOfTreeTest(void) {
  return controllerPidTest();
}

static uint32_t count_in_function(void) {
  static uint32_t count;
  return ++count;
}

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) {
  controllerPid(control, setpoint, sensors, state, stabilizerStep);
  *same  = count_in_function();
  thrust = scale * control->thrust;
}

PARAM_GROUP_START(count)
PARAM_ADD(PARAM_FLOAT, scale, &scale)
PARAM_ADD(PARAM_UINT32 | PARAM_RONLY, inits, &inits)
PARAM_GROUP_STOP(count)

LOG_GROUP_START(count)
LOG_ADD(LOG_UINT32, calls, &calls)
LOG_ADD(LOG_FLOAT, thrust, &thrust)
LOG_GROUP_STOP(count)
