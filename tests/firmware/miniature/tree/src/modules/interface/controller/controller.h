#ifndef CONTROLLER_H_
#define CONTROLLER_H_

#include "autoconf.h"
#include "stabilizer_types.h"

typedef enum {
  ControllerTypeAutoSelect,
  ControllerTypePID,
  ControllerTypeMellinger,
  ControllerTypeINDI,
  ControllerTypeBrescianini,
#if MINIATURE_RELEASE >= 202608
  ControllerTypeLee,
#endif
#ifdef CONFIG_CONTROLLER_OOT
  ControllerTypeOot,
#endif
  ControllerType_COUNT,
} ControllerType;

void controllerInit(ControllerType controller);
bool controllerTest(void);
void controller(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                const state_t *state, const stabilizerStep_t stabilizerStep);
ControllerType controllerGetType(void);
const char    *controllerGetName(void);

#ifdef CONFIG_CONTROLLER_OOT
void controllerOutOfTreeInit(void);
bool controllerOutOfTreeTest(void);
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep);
#endif

#endif  // CONTROLLER_H_
