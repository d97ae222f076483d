// Decides 25 times a second whether the motors may run, and overrides setpoints in every step.
#define DEBUG_MODULE "SUP"

#include "supervisor.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "FreeRTOS.h"
#include "autoconf.h"
#include "cf_math.h"
#include "crtp_commander_high_level.h"
#include "crtp_localization_service.h"
#include "debug.h"
#include "log.h"
#include "motors.h"
#include "param.h"
#include "planner.h"
#include "platform_defaults.h"
#include "power_distribution.h"
#include "supervisor_state_machine.h"
#include "system.h"
#include "task.h"

#define COMMANDER_WDT_TIMEOUT_STABILIZE M2T(500)
#define COMMANDER_WDT_TIMEOUT_SHUTDOWN M2T(2000)
#define EMERGENCY_STOP_TIMEOUT M2T(1000)
#define IS_FLYING_HYSTERESIS_THRESHOLD M2T(2000)

#define FREE_FALL_ACC 0.1f  // [g]
#ifndef SUPERVISOR_TUMBLE_CHECK_ENABLE
#define SUPERVISOR_TUMBLE_CHECK_ENABLE true
#endif
#ifndef SUPERVISOR_TUMBLE_CHECK_ACCEPTED_TILT_ACCZ
#define SUPERVISOR_TUMBLE_CHECK_ACCEPTED_TILT_ACCZ 0.5f  // [g]
#endif
#ifndef SUPERVISOR_TUMBLE_CHECK_ACCEPTED_TILT_TIME
#define SUPERVISOR_TUMBLE_CHECK_ACCEPTED_TILT_TIME 1000  // [ms]
#endif
#ifndef SUPERVISOR_TUMBLE_CHECK_ACCEPTED_UPSIDEDOWN_ACCZ
#define SUPERVISOR_TUMBLE_CHECK_ACCEPTED_UPSIDEDOWN_ACCZ (-0.2f)
#endif
#ifndef SUPERVISOR_TUMBLE_CHECK_ACCEPTED_UPSIDEDOWN_TIME
#define SUPERVISOR_TUMBLE_CHECK_ACCEPTED_UPSIDEDOWN_TIME 100
#endif

#ifndef PREFLIGHT_TIMEOUT_MS
#define PREFLIGHT_TIMEOUT_MS 30000
#endif
#ifndef LANDING_TIMEOUT_MS
#define LANDING_TIMEOUT_MS 3000
#endif

#if (!defined(CONFIG_MOTORS_REQUIRE_ARMING) || (CONFIG_MOTORS_REQUIRE_ARMING == 0))
#define AUTO_ARMING true
#else
#define AUTO_ARMING false
#endif

#define INFO_CAN_ARM 0x0001
#define INFO_IS_ARMED 0x0002
#define INFO_AUTO_ARM 0x0004
#define INFO_CAN_FLY 0x0008
#define INFO_IS_FLYING 0x0010
#define INFO_IS_TUMBLED 0x0020
#define INFO_IS_LOCKED 0x0040
#define INFO_IS_CRASHED 0x0080
#if MINIATURE_RELEASE >= 202608
#define INFO_HL_CONTROL_ACTIVE 0x0100
#define INFO_HL_TRAJ_FINISHED 0x0200
#define INFO_HL_CONTROL_DISABLED 0x0400
#endif

typedef struct {
  bool     canFly;
  bool     isFlying;
  bool     isTumbled;
  bool     isArmed;
  bool     isCrashed;
  uint8_t  paramEmergencyStop;
  uint8_t  doinfodump;
  uint16_t infoBitfield;

  uint32_t initialTumbleTick;  // since when it is tilted, 0: it is not
  uint32_t latestThrustTick;   // when a motor last turned faster than idle, 0: never
  uint32_t latestArmingTick;
  uint32_t latestLandingTick;  // 0: never

  supervisorState_t         state;
  supervisorConditionBits_t latestConditions;
} SupervisorMem_t;

static SupervisorMem_t supervisorMem;
static bool            tumbleCheckEnabled = SUPERVISOR_TUMBLE_CHECK_ENABLE;
#if MINIATURE_RELEASE >= 202512
static uint16_t preflightTimeoutDuration = PREFLIGHT_TIMEOUT_MS;
#endif
static uint16_t landingTimeoutDuration = LANDING_TIMEOUT_MS;

static bool isArmingSpinup(const supervisorState_t state) {
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
  return state == supervisorStateArming;
#endif
#endif
  (void)state;
  return false;
}

static bool canFlyIn(const supervisorState_t state) {
  return state == supervisorStateReadyToFly || state == supervisorStateFlying ||
         state == supervisorStateWarningLevelOut || state == supervisorStateLanded;
}

static bool areMotorsAllowedIn(const supervisorState_t state) {
  return canFlyIn(state) || isArmingSpinup(state);
}

bool supervisorCanFly(void) {
  return supervisorMem.canFly;
}

bool supervisorIsFlying(void) {
  return supervisorMem.isFlying;
}

bool supervisorIsTumbled(void) {
  return supervisorMem.isTumbled;
}

bool supervisorCanArm(void) {
  return supervisorMem.state == supervisorStatePreFlChecksPassed;
}

bool supervisorIsArmed(void) {
  return supervisorMem.isArmed;
}

bool supervisorIsLocked(void) {
  return supervisorMem.state == supervisorStateLocked;
}

bool supervisorIsCrashed(void) {
  return supervisorMem.isCrashed;
}

bool supervisorAreMotorsAllowedToRun(void) {
  return areMotorsAllowedIn(supervisorMem.state);
}

uint16_t supervisorGetInfoBitfield(void) {
  return supervisorMem.infoBitfield;
}

bool supervisorRequestArming(const bool doArm) {
  if (doArm == supervisorMem.isArmed) {
    return true;
  }
  if (doArm && !supervisorCanArm()) {
    return false;
  }
  supervisorMem.isArmed = doArm;
  return true;
}

bool supervisorRequestCrashRecovery(const bool doRecovery) {
  if (!doRecovery) {
    supervisorMem.isCrashed = true;
    return true;
  }
  if (supervisorMem.isCrashed && supervisorIsTumbled()) {
    return false;
  }
  supervisorMem.isCrashed = false;
  return true;
}

#if MINIATURE_RELEASE >= 202608
static bool     isEmergencyStopRequested;
static uint32_t emergencyStopWatchdogTick;  // of the last notification, 0: never

void supervisorRequestEmergencyStop(void) {
  isEmergencyStopRequested = true;
}

void supervisorNotifyEmergencyStopWatchdog(void) {
  emergencyStopWatchdogTick = xTaskGetTickCount();
}

#endif
// ------------------------------------------------------------------------------------ conditions

static bool isFlyingCheck(SupervisorMem_t *this, const uint32_t tick) {
  for (int i = 0; i < NBR_OF_MOTORS; i++) {
    const uint32_t ratio = powerDistributionMotorType(i) * motorsGetRatio(i);
    if (ratio > powerDistributionGetIdleThrust()) {
      this->latestThrustTick = tick;
      break;
    }
  }
  return this->latestThrustTick != 0 &&
         tick - this->latestThrustTick < IS_FLYING_HYSTERESIS_THRESHOLD;
}

static bool isTumbledCheck(SupervisorMem_t *this, const Axis3f *acc, const uint32_t tick) {
  const bool freeFall = fabsf(acc->x) < FREE_FALL_ACC && fabsf(acc->y) < FREE_FALL_ACC &&
                        fabsf(acc->z) < FREE_FALL_ACC;
  if (freeFall || !(acc->z < SUPERVISOR_TUMBLE_CHECK_ACCEPTED_TILT_ACCZ)) {
    this->initialTumbleTick = 0;
    return false;
  }
  if (this->initialTumbleTick == 0) {
    this->initialTumbleTick = tick;
  }
  const uint32_t elapsed = tick - this->initialTumbleTick;
  if (acc->z < SUPERVISOR_TUMBLE_CHECK_ACCEPTED_UPSIDEDOWN_ACCZ &&
      elapsed > M2T(SUPERVISOR_TUMBLE_CHECK_ACCEPTED_UPSIDEDOWN_TIME)) {
    return true;
  }
  return elapsed > M2T(SUPERVISOR_TUMBLE_CHECK_ACCEPTED_TILT_TIME);
}

static bool checkEmergencyStopWatchdog(const uint32_t tick) {
  uint32_t notified = locSrvGetEmergencyStopWatchdogNotificationTick();
#if MINIATURE_RELEASE >= 202608
  notified = MAX(notified, emergencyStopWatchdogTick);
#endif
  return notified > 0 && tick - notified >= EMERGENCY_STOP_TIMEOUT;
}

#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
#define ARMING_SPINUP_TIMEOUT_MS 2000
#define ARMING_RPM_DURATION_MS 200

static uint32_t armingStateTick;  // when the motors began to spin up
static uint32_t rpmValidTick;     // since when all of them spin as they should, 0: they do not

static bool isRpmAtArmingValid(const uint32_t tick) {
  for (int i = 0; i < NBR_OF_MOTORS; i++) {
    const uint16_t rpm = motorsGetRPM(i);
    if (rpm == MOTORS_RPM_INVALID || rpm < CONFIG_MOTORS_ARMING_RPM_MIN ||
        rpm > CONFIG_MOTORS_ARMING_RPM_MAX) {
      rpmValidTick = 0;
      return false;
    }
  }
  if (rpmValidTick == 0) {
    rpmValidTick = tick;
  }
  return tick - rpmValidTick >= M2T(ARMING_RPM_DURATION_MS);
}

#endif
#endif
static supervisorConditionBits_t updateAndPopulateConditions(SupervisorMem_t    *this,
                                                             const sensorData_t *sensors,
                                                             const setpoint_t   *setpoint,
                                                             const uint32_t      currentTick) {
  supervisorConditionBits_t conditions = 0;

  if (supervisorIsArmed()) {
    conditions |= SUPERVISOR_CB_ARMED;
  }
  if (isFlyingCheck(this, currentTick)) {
    conditions |= SUPERVISOR_CB_IS_FLYING;
  }
  // the check follows the vehicle in any case
  const bool isTumbled = isTumbledCheck(this, &sensors->acc, currentTick);
  if (isTumbled && tumbleCheckEnabled) {
    conditions |= SUPERVISOR_CB_IS_TUMBLED;
  }

  const uint32_t setpointAge = currentTick - setpoint->timestamp;
  if (setpointAge > COMMANDER_WDT_TIMEOUT_STABILIZE) {
    conditions |= SUPERVISOR_CB_COMMANDER_WDT_WARNING;
  }
  if (setpointAge > COMMANDER_WDT_TIMEOUT_SHUTDOWN) {
    conditions |= SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT;
  }

  bool isEmergency = checkEmergencyStopWatchdog(currentTick) || locSrvIsEmergencyStopRequested() ||
                     this->paramEmergencyStop;
#if MINIATURE_RELEASE >= 202608
  isEmergency = isEmergency || isEmergencyStopRequested;
#endif
  if (isEmergency) {
    conditions |= SUPERVISOR_CB_EMERGENCY_STOP;
  }
  if (supervisorIsCrashed()) {
    conditions |= SUPERVISOR_CB_CRASHED;
  }
#if MINIATURE_RELEASE >= 202512
  if (this->state == supervisorStateReadyToFly &&
      currentTick - this->latestArmingTick > M2T(preflightTimeoutDuration)) {
    conditions |= SUPERVISOR_CB_PREFLIGHT_TIMEOUT;
  }
#endif
  if (this->latestLandingTick != 0 &&
      currentTick - this->latestLandingTick > M2T(landingTimeoutDuration)) {
    conditions |= SUPERVISOR_CB_LANDING_TIMEOUT;
  }
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
  if (isRpmAtArmingValid(currentTick)) {
    conditions |= SUPERVISOR_CB_RPM_AT_ARMING_VALID;
  }
  if (this->state == supervisorStateArming &&
      currentTick - armingStateTick > M2T(ARMING_SPINUP_TIMEOUT_MS)) {
    conditions |= SUPERVISOR_CB_SPINUP_TIMEOUT;
  }
#endif
#endif
  return conditions;
}

// ------------------------------------------------------------------------------------ transitions

static void tell(const supervisorState_t from, const supervisorState_t to) {
  if (to == supervisorStateLocked) {
    DEBUG_PRINT("Locked, reboot required\n");
  } else if (to == supervisorStateCrashed) {
    DEBUG_PRINT("Crashed, recovery required\n");
  } else if (AUTO_ARMING) {
    return;
  } else if (to == supervisorStateReadyToFly) {
    DEBUG_PRINT("Ready to fly\n");
  } else if ((to == supervisorStateReset || from == supervisorStateReadyToFly) &&
             !areMotorsAllowedIn(to)) {
    DEBUG_PRINT("Disarming\n");
  }
}

static void postTransitionActions(SupervisorMem_t *this, const supervisorState_t previousState,
                                  const uint32_t currentTick) {
  const supervisorState_t newState = this->state;

  tell(previousState, newState);
  if (newState == supervisorStateReadyToFly) {
    this->latestArmingTick = currentTick;
  }
  if (newState == supervisorStateLanded) {
    this->latestLandingTick = currentTick;
  }
  if (newState == supervisorStateCrashed) {
    supervisorRequestCrashRecovery(false);
  }
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
  if (newState == supervisorStateArming) {
    armingStateTick = currentTick;
    rpmValidTick    = 0;
  }
#endif
#endif
  if (!areMotorsAllowedIn(newState)) {
    supervisorRequestArming(false);
  }
  if (AUTO_ARMING && newState == supervisorStatePreFlChecksPassed) {
    supervisorRequestArming(true);
  }
}

static uint16_t updateInfoBitfield(const SupervisorMem_t *this) {
  uint16_t bitfield = 0;

  bitfield |= supervisorCanArm() ? INFO_CAN_ARM : 0;
  bitfield |= supervisorIsArmed() ? INFO_IS_ARMED : 0;
  bitfield |= AUTO_ARMING ? INFO_AUTO_ARM : 0;
  bitfield |= this->canFly ? INFO_CAN_FLY : 0;
  bitfield |= this->isFlying ? INFO_IS_FLYING : 0;
  bitfield |= this->isTumbled ? INFO_IS_TUMBLED : 0;
  bitfield |= supervisorIsLocked() ? INFO_IS_LOCKED : 0;
  bitfield |= supervisorIsCrashed() ? INFO_IS_CRASHED : 0;
#if MINIATURE_RELEASE >= 202608
  const enum trajectory_state plannerState = crtpCommanderHighLevelGetPlannerState();
  bitfield |= (plannerState & 1) == 1 ? INFO_HL_CONTROL_ACTIVE : 0;
  bitfield |= crtpCommanderHighLevelIsTrajectoryFinished() ? INFO_HL_TRAJ_FINISHED : 0;
  bitfield |= plannerState == TRAJECTORY_STATE_DISABLED ? INFO_HL_CONTROL_DISABLED : 0;
#endif
  return bitfield;
}

static void infoDump(const SupervisorMem_t *this) {
  DEBUG_PRINT("state: %s\n", supervisorGetStateName(this->state));
  for (int i = 0; i < supervisorCondition_NrOfConditions; i++) {
    const bool isSet = (this->latestConditions & (1 << i)) != 0;
    DEBUG_PRINT("%s%s\n", isSet ? "[x] " : "[ ] ", supervisorGetConditionName(i));
  }
}

void supervisorUpdate(const sensorData_t *sensors, const setpoint_t *setpoint,
                      stabilizerStep_t stabilizerStep) {
  if (!RATE_DO_EXECUTE(RATE_SUPERVISOR, stabilizerStep)) {
    return;
  }
  SupervisorMem_t *this        = &supervisorMem;
  const uint32_t   currentTick = xTaskGetTickCount();

  if (this->doinfodump) {
    infoDump(this);
    this->doinfodump = 0;
  }

  this->latestConditions = updateAndPopulateConditions(this, sensors, setpoint, currentTick);

  const supervisorState_t previousState = this->state;
  this->state = supervisorStateUpdate(previousState, this->latestConditions);
  if (this->state != previousState) {
    postTransitionActions(this, previousState, currentTick);
  }

  this->canFly = canFlyIn(this->state);
  this->isFlying =
      this->state == supervisorStateFlying || this->state == supervisorStateWarningLevelOut;
  this->isTumbled    = (this->latestConditions & SUPERVISOR_CB_IS_TUMBLED) != 0;
  this->infoBitfield = updateInfoBitfield(this);
}

void supervisorOverrideSetpoint(setpoint_t *setpoint) {
  static const setpoint_t nullSetpoint;

  switch (supervisorMem.state) {
    case supervisorStateReadyToFly:
    case supervisorStateFlying:
    case supervisorStateLanded:
      break;

    case supervisorStateWarningLevelOut:
      setpoint->mode.x           = modeDisable;
      setpoint->mode.y           = modeDisable;
      setpoint->mode.roll        = modeAbs;
      setpoint->mode.pitch       = modeAbs;
      setpoint->mode.yaw         = modeVelocity;
      setpoint->attitude.roll    = 0;
      setpoint->attitude.pitch   = 0;
      setpoint->attitudeRate.yaw = 0;
      // the height stays as it was asked for
      break;

    default:
      memcpy(setpoint, &nullSetpoint, sizeof(nullSetpoint));
      break;
  }
}

LOG_GROUP_START(sys)
LOG_ADD_CORE(LOG_UINT8, canfly, &supervisorMem.canFly)
LOG_ADD_CORE(LOG_UINT8, isFlying, &supervisorMem.isFlying)
LOG_ADD_CORE(LOG_UINT8, isTumbled, &supervisorMem.isTumbled)
LOG_ADD(LOG_UINT8, armed, &supervisorMem.isArmed)
LOG_GROUP_STOP(sys)

LOG_GROUP_START(supervisor)
LOG_ADD(LOG_UINT16, info, &supervisorMem.infoBitfield)
LOG_GROUP_STOP(supervisor)

PARAM_GROUP_START(stabilizer)
PARAM_ADD_CORE(PARAM_UINT8, stop, &supervisorMem.paramEmergencyStop)
PARAM_GROUP_STOP(stabilizer)

PARAM_GROUP_START(supervisor)
PARAM_ADD(PARAM_UINT8, infdmp, &supervisorMem.doinfodump)
#if MINIATURE_RELEASE >= 202512
PARAM_ADD(PARAM_UINT16 | PARAM_PERSISTENT, prefltTimeout, &preflightTimeoutDuration)
#endif
PARAM_ADD(PARAM_UINT16 | PARAM_PERSISTENT, landedTimeout, &landingTimeoutDuration)
PARAM_ADD(PARAM_UINT8 | PARAM_PERSISTENT, tmblChckEn, &tumbleCheckEnabled)
PARAM_GROUP_STOP(supervisor)
