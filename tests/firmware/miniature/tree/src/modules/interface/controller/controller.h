// The controllers, by number. Whether there is one out of the tree depends on what came before.
#ifndef __CONTROLLER_H__
#define __CONTROLLER_H__

#include "stabilizer_types.h"

typedef enum {
  ControllerTypeAutoSelect,
  ControllerTypePID,
  ControllerTypeMellinger,
  ControllerTypeINDI,
  ControllerTypeBrescianini,
#if MINIATURE_RELEASE >= 202512
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
const char    *controllerGetName();
#if MINIATURE_RELEASE >= 202609
void controllerEnterPreciseLanding(void);
void controllerExitPreciseLanding(void);
#endif

#ifdef CONFIG_CONTROLLER_OOT
void controllerOutOfTreeInit(void);
bool controllerOutOfTreeTest(void);
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep);
#if MINIATURE_RELEASE >= 202609
void controllerOutOfTreeEnterPreciseLanding(void);
void controllerOutOfTreeExitPreciseLanding(void);
#endif
#endif

#endif  //__CONTROLLER_H__
