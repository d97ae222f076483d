// Hands on to the firmware's controllers, as the first example of every app does.

#include "app_modes.h"
#include "controller.h"
#include "controller_brescianini.h"
#include "controller_indi.h"
#include "controller_lee.h"
#include "controller_mellinger.h"
#include "controller_pid.h"

static int started;

static void start(int type) {
  switch (type) {
    case ControllerTypePID:
      controllerPidInit();
      break;
    case ControllerTypeMellinger:
      controllerMellingerFirmwareInit();
      break;
    case ControllerTypeINDI:
      controllerINDIInit();
      break;
    case ControllerTypeBrescianini:
      controllerBrescianiniInit();
      break;
    default:
      controllerLeeFirmwareInit();
      break;
  }
}

void forward_to_controller(const call_t *call, int type) {
  if (started != type) {
    started = type;
    start(type);
  }
  switch (type) {
    case ControllerTypePID:
      controllerPid(call->control, call->setpoint, call->sensors, call->state, call->step);
      break;
    case ControllerTypeMellinger:
      controllerMellingerFirmware(call->control, call->setpoint, call->sensors, call->state,
                                  call->step);
      break;
    case ControllerTypeINDI:
      controllerINDI(call->control, call->setpoint, call->sensors, call->state, call->step);
      break;
    case ControllerTypeBrescianini:
      controllerBrescianini(call->control, call->setpoint, call->sensors, call->state, call->step);
      break;
    default:
      controllerLeeFirmware(call->control, call->setpoint, call->sensors, call->state, call->step);
      break;
  }
}
