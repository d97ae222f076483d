// The controller of the test app: does what parameter testApp.mode says.

#include "app.h"
#include "app_modes.h"
#include "controller.h"
#include "param.h"

// modes up to the number of controllers forward to the one of that number
enum { COUNT = 10, READ_VARIABLES = 11, PRINT = 12, PARTS = 13, FAULT = 20 };

static uint8_t  mode = COUNT;
static uint8_t  refuse;
static uint32_t selected;

void controllerOutOfTreeInit(void) {
  selected++;
}

bool controllerOutOfTreeTest(void) {
  return refuse == 0;
}

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) {
  const call_t call = {control, setpoint, sensors, state, stabilizerStep};
  switch (mode) {
    case COUNT:
      count(&call);
      break;
    case READ_VARIABLES:
      read_variables(&call);
      break;
    case PRINT:
      print(&call);
      break;
    case PARTS:
      call_parts(&call);
      break;
    default:
      if (mode >= FAULT) {
        fault(mode - FAULT);
      } else {
        forward_to_controller(&call, mode);
      }
  }
}

void appMain(void) {
  selected = 1000;  // never happens
}

PARAM_GROUP_START(testApp)
PARAM_ADD(PARAM_UINT8, mode, &mode)
PARAM_ADD(PARAM_UINT8, refuse, &refuse)
PARAM_ADD_CORE(PARAM_UINT32 | PARAM_RONLY, selected, &selected)
PARAM_GROUP_STOP(testApp)
