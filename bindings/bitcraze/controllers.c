#include "bitcraze/adapter.h"

#include "bitcraze/conversions.h"
#include "bitcraze/geometric_controllers.h"
#include "controller.h"
#include "controller_pid.h"
#include "library/out_of_tree.h"
#include "position_controller.h"

#if CF_WITH_CONTROLLER_BRESCIANINI
#include "controller_brescianini.h"
#endif

#define HAS_INDI (CF_WITH_CONTROLLER_INDI && CF_WITH_POSITION_CONTROLLER_INDI)
#if HAS_INDI
#include "controller_indi.h"
#endif

// What the vehicle's table of controllers has, in the form of its rows.
typedef struct {
  const char *name;  // null: not part of this library
  void (*init)(void);
  void (*update)(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                 const state_t *state, const stabilizerStep_t stabilizerStep);
} row_t;

static const row_t ROWS[api_ControllerType_COUNT] = {
    [api_ControllerTypePID] = {"PID", controllerPidInit, controllerPid},
#if CF_WITH_CONTROLLER_MELLINGER
    [api_ControllerTypeMellinger] = {"Mellinger", cf_mellinger_select, cf_mellinger_run},
#endif
#if HAS_INDI
    [api_ControllerTypeINDI] = {"INDI", controllerINDIInit, controllerINDI},
#endif
#if CF_WITH_CONTROLLER_BRESCIANINI
    [api_ControllerTypeBrescianini] = {"Brescianini", controllerBrescianiniInit,
                                       controllerBrescianini},
#endif
#if CF_WITH_CONTROLLER_LEE && HAVE_CONTROLLER_LEE
    [api_ControllerTypeLee] = {"Lee", cf_lee_select, cf_lee_run},
#endif
    [api_ControllerTypeOot] = {CF_OUT_OF_TREE_NAME, cf_out_of_tree_init_controller,
                               cf_out_of_tree_control},
};

// what the configuration may put in place of PID
#if CONFIG_CONTROLLER_MELLINGER
#define DEFAULT_CONTROLLER api_ControllerTypeMellinger
#elif CONFIG_CONTROLLER_INDI
#define DEFAULT_CONTROLLER api_ControllerTypeINDI
#elif CONFIG_CONTROLLER_BRESCIANINI
#define DEFAULT_CONTROLLER api_ControllerTypeBrescianini
#elif CONFIG_CONTROLLER_LEE
#define DEFAULT_CONTROLLER api_ControllerTypeLee
#else
#define DEFAULT_CONTROLLER api_ControllerTypePID
#endif

static int active;  // a number of ours, which may differ from the checkout's

static const row_t *row_of(int type) {
  if (type < 0 || type >= api_ControllerType_COUNT ||
      (type == api_ControllerTypeOot && !cf_out_of_tree_has_controller())) {
    return NULL;
  }
  return ROWS[type].name != NULL ? &ROWS[type] : NULL;
}

const char *cf_controllers_name(int type) {
  const row_t *row = row_of(type);
  return row != NULL ? row->name : NULL;
}

int cf_controllers_type(const void *state CF_UNUSED) {
#if CF_SYSTEM
  return (int)controllerGetType();
#else
  return active;
#endif
}

// As on the vehicle: the row's own init, which resets what it resets. That of PID leaves the
// attitude loops as they are once they were started.
cf_status_t cf_controllers_init(void *state CF_UNUSED, int type) {
  int wanted = type;
  if (type == api_ControllerTypeAutoSelect) {
    wanted = row_of(DEFAULT_CONTROLLER) != NULL ? DEFAULT_CONTROLLER : api_ControllerTypePID;
  }
  const row_t *row = row_of(wanted);
  if (row == NULL) {
    return CF_ERR_UNKNOWN;
  }
  active = wanted;
  row->init();
  return CF_OK;
}

void cf_controllers_boot(void) {
  cf_geometric_controllers_boot();
  cf_controllers_init(NULL, api_ControllerTypeAutoSelect);
}

void cf_controllers_run(void *state CF_UNUSED, api_control_t *control,
                        const api_setpoint_t *setpoint, const api_sensorData_t *sensors,
                        const api_state_t *estimate, api_stabilizerStep_t step) {
  control_t          theirs   = cf_checkout_control(control);
  const sensorData_t measured = cf_checkout_sensors(sensors);
  const state_t      is       = cf_checkout_state(estimate);
  setpoint_t         wanted;
  cf_checkout_setpoint(&wanted, setpoint);
  ROWS[active].update(&theirs, &wanted, &measured, &is, step);
  cf_api_control(control, &theirs);
}

void cf_controllers_reset_position(void *state CF_UNUSED, const api_point_t *position) {
#if HAVE_POSITION_RESET_AT
  positionControllerResetAllPID(position->x, position->y, position->z);
#else
  (void)position;
  positionControllerResetAllPID();
#endif
  positionControllerResetAllfilters();
}
