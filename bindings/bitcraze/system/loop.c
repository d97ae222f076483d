/* What the loop came to, and, where the checkout's own loop is not part of the library, a loop of
 * ours around its modules. */
#include "bitcraze/system/system.h"

// clang-format off: the operating system first
#include "FreeRTOS.h"
#include "task.h"
#include "controller.h"
#include "supervisor_state_machine.h"
// clang-format on

// Numbers of onboard/supervisor_state_machine.h, whose names are those of the checkout.
enum {
  OUR_NOT_INITIALIZED,
  OUR_CHECKS_NOT_PASSED,
  OUR_CHECKS_PASSED,
  OUR_READY_TO_FLY,
  OUR_FLYING,
  OUR_LANDED,
  OUR_RESET,
  OUR_WARNING_LEVEL_OUT,
  OUR_FREE_FALL,
  OUR_LOCKED,
  OUR_CRASHED,
};

cf_system_seen_t   cf_system_seen;
cf_system_wanted_t cf_system_wanted;

// The linker redirects all calls of controller() here, and those of __real_controller() to
// controller.c (-Wl,--wrap): inputs and outputs of the control loop pass through this function.
void __real_controller(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                       const state_t *state, const stabilizerStep_t stabilizerStep);
void __wrap_controller(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                       const state_t *state, const stabilizerStep_t stabilizerStep);

void __wrap_controller(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                       const state_t *state, const stabilizerStep_t stabilizerStep) {
  __real_controller(control, setpoint, sensors, state, stabilizerStep);
  cf_system_seen.step     = stabilizerStep + 1;  // as ours counts: the one that comes next
  cf_system_seen.estimate = *state;
  cf_system_seen.setpoint = *setpoint;
  cf_system_seen.control  = *control;
}

int cf_system_supervisor_state;

// The same for the state machine of the supervisor. Releases differ in the numbers of states, and
// some have one that ours has not: with it a drone arms.
supervisorState_t __real_supervisorStateUpdate(const supervisorState_t         state,
                                               const supervisorConditionBits_t conditions);
supervisorState_t __wrap_supervisorStateUpdate(const supervisorState_t         state,
                                               const supervisorConditionBits_t conditions);

static int our_number(supervisorState_t state) {
  switch (state) {
    case supervisorStateNotInitialized:
      return OUR_NOT_INITIALIZED;
    case supervisorStatePreFlChecksNotPassed:
      return OUR_CHECKS_NOT_PASSED;
    case supervisorStateReadyToFly:
      return OUR_READY_TO_FLY;
    case supervisorStateFlying:
      return OUR_FLYING;
    case supervisorStateLanded:
      return OUR_LANDED;
    case supervisorStateReset:
      return OUR_RESET;
    case supervisorStateWarningLevelOut:
      return OUR_WARNING_LEVEL_OUT;
    case supervisorStateExceptFreeFall:
      return OUR_FREE_FALL;
    case supervisorStateLocked:
      return OUR_LOCKED;
#if HAVE_SUPERVISOR_CRASHED
    case supervisorStateCrashed:
      return OUR_CRASHED;
#endif
    default:
      return OUR_CHECKS_PASSED;
  }
}

supervisorState_t __wrap_supervisorStateUpdate(const supervisorState_t         state,
                                               const supervisorConditionBits_t conditions) {
  const supervisorState_t next = __real_supervisorStateUpdate(state, conditions);
  cf_system_supervisor_state   = our_number(next);
  return next;
}

#if !CF_WITH_STABILIZER

// clang-format off: some headers use what they do not include
#include "collision_avoidance.h"
#include "commander.h"
#include "crtp_commander_high_level.h"
#include "estimator.h"
#include "power_distribution.h"
#include "sensors.h"
#include "supervisor.h"
// clang-format on

#include "bitcraze/rtos/hardware.h"

#define PRIORITY 5
#define SUPPLY_START 4.2f         // [V], docs/reference/control-pid.md#14
#define SUPPLY_FILTER_GAIN 0.01f  // per control of the motors

void     stabilizerInit(StateEstimatorType estimator);
bool     stabilizerTest(void);
void     motorsSetRatio(uint32_t id, uint16_t ratio);
void     motorsStop(void);
uint16_t testsound[4] __attribute__((weak));

static StackType_t  stack[1];  // tasks run on stacks of ours
static StaticTask_t task;

static sensorData_t sensors;
static state_t      estimate;
static setpoint_t   setpoint;
static control_t    control;
static float        supply_voltage = SUPPLY_START;

static void control_motors(void) {
  motors_thrust_uncapped_t uncapped;
  motors_thrust_pwm_t      pwm;
  powerDistribution(&control, &uncapped);
#if HAVE_MOTORS_COMPENSATE
  float motorsCompensateBatteryVoltage(uint32_t id, float iThrust, float supplyVoltage);
  supply_voltage += SUPPLY_FILTER_GAIN * (cf_hardware_battery - supply_voltage);
  for (int i = 0; i < CF_HARDWARE_MOTORS; i++) {
    uncapped.list[i] = (int32_t)motorsCompensateBatteryVoltage((uint32_t)i, (float)uncapped.list[i],
                                                               supply_voltage);
  }
#endif
  powerDistributionCap(&uncapped, &pwm);
  for (int i = 0; i < CF_HARDWARE_MOTORS; i++) {
    motorsSetRatio((uint32_t)i, pwm.list[i]);
  }
}

// One iteration, in the order of docs/reference/control-pid.md#4.
static void iterate(stabilizerStep_t step) {
#if HAVE_SENSORS_ACQUIRE_TICK
  sensorsAcquire(&sensors, step);
#else
  sensorsAcquire(&sensors);
#endif
  if ((int)stateEstimatorGetType() != cf_system_wanted.estimator) {
    stateEstimatorSwitchTo((StateEstimatorType)cf_system_wanted.estimator);
  }
  if ((int)controllerGetType() != cf_system_wanted.controller) {
    controllerInit((ControllerType)cf_system_wanted.controller);
  }
  stateEstimator(&estimate, step);

  // decided in an earlier iteration: motors start one step after the state allows them
  const bool are_motors_allowed = supervisorAreMotorsAllowedToRun();
  crtpCommanderBlock(!are_motors_allowed);
  static setpoint_t planned;
  if (crtpCommanderHighLevelGetSetpoint(&planned, &estimate, step)) {
    commanderSetSetpoint(&planned, COMMANDER_PRIORITY_HIGHLEVEL);
  }
  commanderGetSetpoint(&setpoint, &estimate);
  supervisorUpdate(&sensors, &setpoint, step);
  collisionAvoidanceUpdateSetpoint(&setpoint, &sensors, &estimate, step);
  supervisorOverrideSetpoint(&setpoint);
  __wrap_controller(&control, &setpoint, &sensors, &estimate, step);
  if (are_motors_allowed) {
    control_motors();
  } else {
    motorsStop();
  }
}

static void run(void *nothing CF_UNUSED) {
  TickType_t previous = xTaskGetTickCount();
  while (!sensorsAreCalibrated()) {
    vTaskDelayUntil(&previous, 1);
  }
  for (stabilizerStep_t step = 1;;) {
    sensorsWaitDataReady();
    if (!cf_system_wanted.is_held) {
      iterate(step++);
    }
  }
}

void stabilizerInit(StateEstimatorType estimator) {
  sensorsInit();
  stateEstimatorInit(estimator);
  controllerInit(ControllerTypeAutoSelect);
  powerDistributionInit();
  collisionAvoidanceInit();
  xTaskCreateStatic(run, "STABILIZER", sizeof stack, NULL, PRIORITY, stack, &task);
}

bool stabilizerTest(void) {
  return sensorsTest() & stateEstimatorTest() & controllerTest() & powerDistributionTest() &
         collisionAvoidanceTest();
}
#endif
