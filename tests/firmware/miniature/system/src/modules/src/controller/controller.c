// The controllers, and which of them flies.
#define DEBUG_MODULE "CONTROLLER"

// clang-format off
#include "debug.h"

#include "cfassert.h"
#include "controller.h"
#include "controller_pid.h"
#include "controller_mellinger.h"
#include "controller_indi.h"
#include "controller_brescianini.h"
#if MINIATURE_RELEASE >= 202512
#include "controller_lee.h"
#endif

#include "autoconf.h"
// clang-format on

#define DEFAULT_CONTROLLER ControllerTypePID

#if defined(CONFIG_CONTROLLER_PID)
#define FORCED_CONTROLLER ControllerTypePID
#elif defined(CONFIG_CONTROLLER_INDI)
#define FORCED_CONTROLLER ControllerTypeINDI
#elif defined(CONFIG_CONTROLLER_MELLINGER)
#define FORCED_CONTROLLER ControllerTypeMellinger
#elif defined(CONFIG_CONTROLLER_BRESCIANINI)
#define FORCED_CONTROLLER ControllerTypeBrescianini
#if MINIATURE_RELEASE >= 202512
#elif defined(CONFIG_CONTROLLER_LEE)
#define FORCED_CONTROLLER ControllerTypeLee
#endif
#elif defined(CONFIG_CONTROLLER_OOT)
#define FORCED_CONTROLLER ControllerTypeOot
#endif

static ControllerType currentController = ControllerTypeAutoSelect;

static void initController(void);

typedef struct {
  void (*init)(void);
  bool (*test)(void);
  void (*update)(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                 const state_t *state, const stabilizerStep_t stabilizerStep);
#if MINIATURE_RELEASE >= 202609
  void (*enterPreciseLanding)(void);
  void (*exitPreciseLanding)(void);
#endif
  const char *name;
} ControllerFcns;

static ControllerFcns controllerFunctions[] = {
    {.init = 0, .test = 0, .update = 0, .name = "None"},
    {.init   = controllerPidInit,
     .test   = controllerPidTest,
     .update = controllerPid,
#if MINIATURE_RELEASE >= 202609
     .enterPreciseLanding = controllerPidEnterPreciseLanding,
     .exitPreciseLanding  = controllerPidExitPreciseLanding,
#endif
     .name = "PID"},
    {.init   = controllerMellingerFirmwareInit,
     .test   = controllerMellingerFirmwareTest,
     .update = controllerMellingerFirmware,
#if MINIATURE_RELEASE >= 202609
     .enterPreciseLanding = controllerMellingerFirmwareEnterPreciseLanding,
     .exitPreciseLanding  = controllerMellingerFirmwareExitPreciseLanding,
#endif
     .name = "Mellinger"},
    {.init   = controllerINDIInit,
     .test   = controllerINDITest,
     .update = controllerINDI,
#if MINIATURE_RELEASE >= 202609
     .enterPreciseLanding = controllerINDIEnterPreciseLanding,
     .exitPreciseLanding  = controllerINDIExitPreciseLanding,
#endif
     .name = "INDI"},
    {.init   = controllerBrescianiniInit,
     .test   = controllerBrescianiniTest,
     .update = controllerBrescianini,
#if MINIATURE_RELEASE >= 202609
     .enterPreciseLanding = controllerBrescianiniEnterPreciseLanding,
     .exitPreciseLanding  = controllerBrescianiniExitPreciseLanding,
#endif
     .name = "Brescianini"},
#if MINIATURE_RELEASE >= 202512
    {.init   = controllerLeeFirmwareInit,
     .test   = controllerLeeFirmwareTest,
     .update = controllerLeeFirmware,
#if MINIATURE_RELEASE >= 202609
     .enterPreciseLanding = controllerLeeFirmwareEnterPreciseLanding,
     .exitPreciseLanding  = controllerLeeFirmwareExitPreciseLanding,
#endif
     .name = "Lee"},
#endif
#ifdef CONFIG_CONTROLLER_OOT
    {.init   = controllerOutOfTreeInit,
     .test   = controllerOutOfTreeTest,
     .update = controllerOutOfTree,
#if MINIATURE_RELEASE >= 202609
     .enterPreciseLanding = controllerOutOfTreeEnterPreciseLanding,
     .exitPreciseLanding  = controllerOutOfTreeExitPreciseLanding,
#endif
     .name = "OutOfTree"},
#endif
};

void controllerInit(ControllerType controller) {
  if (controller < 0 || controller >= ControllerType_COUNT) {
    return;
  }
  currentController = controller;
  if (currentController == ControllerTypeAutoSelect) {
    currentController = DEFAULT_CONTROLLER;
  }
#ifdef FORCED_CONTROLLER
  DEBUG_PRINT("Controller type forced\n");
  currentController = FORCED_CONTROLLER;
#endif

  initController();
  DEBUG_PRINT("Using %s (%d) controller\n", controllerGetName(), currentController);
}

ControllerType controllerGetType(void) {
  return currentController;
}

static void initController(void) {
  controllerFunctions[currentController].init();
}

bool controllerTest(void) {
  return controllerFunctions[currentController].test();
}

void controller(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                const state_t *state, const stabilizerStep_t stabilizerStep) {
  controllerFunctions[currentController].update(control, setpoint, sensors, state, stabilizerStep);
}

const char *controllerGetName() {
  return controllerFunctions[currentController].name;
}
#if MINIATURE_RELEASE >= 202609

void controllerEnterPreciseLanding(void) {
  controllerFunctions[currentController].enterPreciseLanding();
}

void controllerExitPreciseLanding(void) {
  controllerFunctions[currentController].exitPreciseLanding();
}
#endif
