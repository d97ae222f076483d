// The loop, a thousand times a second: from the sensors to the motors.
#define DEBUG_MODULE "STAB"

// clang-format off
#include <math.h>

#include "FreeRTOS.h"
#include "task.h"
#include "semphr.h"

#include "system.h"
#include "log.h"
#include "param.h"
#include "debug.h"
#include "motors.h"
#include "pm.h"
#include "platform.h"

#include "stabilizer.h"

#include "sensors.h"
#include "commander.h"
#include "crtp_commander_high_level.h"
#include "crtp_localization_service.h"
#include "controller.h"
#include "power_distribution.h"
#include "collision_avoidance.h"
#include "health.h"
#include "supervisor.h"

#include "estimator.h"
#include "usddeck.h"
#include "quatcompress.h"
#include "statsCnt.h"
#include "static_mem.h"
#include "rateSupervisor.h"
// clang-format on

static bool isInit;

static uint32_t inToOutLatency;  // [us]

static setpoint_t               setpoint;
static sensorData_t             sensorData;
static state_t                  state;
static control_t                control;
static motors_thrust_uncapped_t motorThrustUncapped;
static motors_thrust_uncapped_t motorThrustBatCompUncapped;
static motors_thrust_pwm_t      motorPwm;

// as parameters; an unknown number is replaced by what is active
static StateEstimatorType estimatorType;
static ControllerType     controllerType;

static STATS_CNT_RATE_DEFINE(stabilizerRate, 500);
static rateSupervisor_t rateSupervisorContext;
static bool             rateWarningDisplayed = false;

// in half the bytes
static struct {
  int16_t x, y, z;                       // [mm]
  int16_t vx, vy, vz;                    // [mm/s]
  int16_t ax, ay, az;                    // [mm/s^2], with gravity
  int32_t quat;                          // see quatcompress.h
  int16_t rateRoll, ratePitch, rateYaw;  // [mrad/s]
} stateCompressed;

static struct {
  int16_t x, y, z;     // [mm]
  int16_t vx, vy, vz;  // [mm/s]
  int16_t ax, ay, az;  // [mm/s^2]
} setpointCompressed;

STATIC_MEM_TASK_ALLOC(stabilizerTask, STABILIZER_TASK_STACKSIZE);
static void stabilizerTask(void *param);
#if MINIATURE_RELEASE >= 202512

STATIC_MEM_TASK_ALLOC(rateSupervisorTask, RATE_SUPERVISOR_TASK_STACKSIZE);
static void              rateSupervisorTask(void *param);
static SemaphoreHandle_t xRateSupervisorSemaphore;
#endif

// What no int32 holds saturates, as on the vehicle's processor.
static int32_t wholeNumber(float value) {
  if (!(value >= -2147483648.0f)) {
    return isnan(value) ? 0 : INT32_MIN;
  }
  return value >= 2147483648.0f ? INT32_MAX : (int32_t)value;
}

static int16_t whole(float value) {
  return (int16_t)wholeNumber(value);
}

static void compressState(void) {
  stateCompressed.x = whole(state.position.x * 1000.0f);
  stateCompressed.y = whole(state.position.y * 1000.0f);
  stateCompressed.z = whole(state.position.z * 1000.0f);

  stateCompressed.vx = whole(state.velocity.x * 1000.0f);
  stateCompressed.vy = whole(state.velocity.y * 1000.0f);
  stateCompressed.vz = whole(state.velocity.z * 1000.0f);

  stateCompressed.ax = whole(state.acc.x * 9.81f * 1000.0f);
  stateCompressed.ay = whole(state.acc.y * 9.81f * 1000.0f);
  stateCompressed.az = whole((state.acc.z + 1) * 9.81f * 1000.0f);

  const float q[4]     = {state.attitudeQuaternion.x, state.attitudeQuaternion.y,
                          state.attitudeQuaternion.z, state.attitudeQuaternion.w};
  stateCompressed.quat = quatcompress(q);

  const float deg2millirad  = 3.14159265358979f * 1000.0f / 180.0f;
  stateCompressed.rateRoll  = whole(sensorData.gyro.x * deg2millirad);
  stateCompressed.ratePitch = whole(-sensorData.gyro.y * deg2millirad);
  stateCompressed.rateYaw   = whole(sensorData.gyro.z * deg2millirad);
}

static void compressSetpoint(void) {
  setpointCompressed.x = whole(setpoint.position.x * 1000.0f);
  setpointCompressed.y = whole(setpoint.position.y * 1000.0f);
  setpointCompressed.z = whole(setpoint.position.z * 1000.0f);

  setpointCompressed.vx = whole(setpoint.velocity.x * 1000.0f);
  setpointCompressed.vy = whole(setpoint.velocity.y * 1000.0f);
  setpointCompressed.vz = whole(setpoint.velocity.z * 1000.0f);

  setpointCompressed.ax = whole(setpoint.acceleration.x * 1000.0f);
  setpointCompressed.ay = whole(setpoint.acceleration.y * 1000.0f);
  setpointCompressed.az = whole(setpoint.acceleration.z * 1000.0f);
}

static void calcSensorToOutputLatency(const sensorData_t *sensors) {
  const uint64_t outTimestamp = usecTimestamp();
  inToOutLatency              = outTimestamp - sensors->interruptTimestamp;
}

void stabilizerInit(StateEstimatorType estimator) {
  if (isInit) {
    return;
  }
  sensorsInit();
  stateEstimatorInit(estimator);
  controllerInit(ControllerTypeAutoSelect);
  powerDistributionInit();
  motorsInit(platformConfigGetMotorMapping());
  collisionAvoidanceInit();
  estimatorType  = stateEstimatorGetType();
  controllerType = controllerGetType();

  STATIC_MEM_TASK_CREATE(stabilizerTask, stabilizerTask, STABILIZER_TASK_NAME, NULL,
                         STABILIZER_TASK_PRI);
  isInit = true;
}

bool stabilizerTest(void) {
  bool pass = true;
  pass &= sensorsTest();
  pass &= stateEstimatorTest();
  pass &= controllerTest();
  pass &= powerDistributionTest();
  pass &= motorsTest();
  pass &= collisionAvoidanceTest();
  return pass;
}

static void batteryCompensation(const motors_thrust_uncapped_t *uncapped,
                                motors_thrust_uncapped_t       *compensated) {
#if MINIATURE_RELEASE >= 202512
  static float supplyVoltage = 4.2f;

  supplyVoltage += 0.01f * (pmGetBatteryVoltage() - supplyVoltage);
#else
  const float supplyVoltage = pmGetBatteryVoltage();
#endif
  for (int motor = 0; motor < STABILIZER_NR_OF_MOTORS; motor++) {
    compensated->list[motor] =
        wholeNumber(motorsCompensateBatteryVoltage(motor, uncapped->list[motor], supplyVoltage));
  }
}

static void setMotorRatios(const motors_thrust_pwm_t *pwm) {
  motorsSetRatio(MOTOR_M1, pwm->motors.m1);
  motorsSetRatio(MOTOR_M2, pwm->motors.m2);
  motorsSetRatio(MOTOR_M3, pwm->motors.m3);
  motorsSetRatio(MOTOR_M4, pwm->motors.m4);
}

#ifdef CONFIG_LOG_MOTOR_CAP_WARNING
static void warnOfCap(bool isCapped) {
  static uint32_t nextReportTick = 0;

  const uint32_t tick = xTaskGetTickCount();
  if (isCapped && tick > nextReportTick) {
    DEBUG_PRINT("Warning: motor thrust saturated\n");
    nextReportTick = tick + M2T(3000);
  }
}
#endif

static void controlMotors(const control_t *wanted) {
  powerDistribution(wanted, &motorThrustUncapped);
  batteryCompensation(&motorThrustUncapped, &motorThrustBatCompUncapped);
#if MINIATURE_RELEASE >= 202512
  const bool isCapped = powerDistributionCap(&motorThrustBatCompUncapped, &motorPwm);
#ifdef CONFIG_LOG_MOTOR_CAP_WARNING
  warnOfCap(isCapped);
#else
  (void)isCapped;
#endif
#else
  powerDistributionCap(&motorThrustBatCompUncapped, &motorPwm);
#endif
  setMotorRatios(&motorPwm);
}

static void updateStateEstimatorAndControllerTypes(void) {
  if (stateEstimatorGetType() != estimatorType) {
    stateEstimatorSwitchTo(estimatorType);
    estimatorType = stateEstimatorGetType();
  }
  if (controllerGetType() != controllerType) {
    controllerInit(controllerType);
    controllerType = controllerGetType();
  }
}

static void logUsd(const stabilizerStep_t stabilizerStep) {
#ifdef CONFIG_DECK_USD
  if (usddeckLoggingEnabled() && RATE_DO_EXECUTE(usddeckFrequency(), stabilizerStep)) {
    usddeckTriggerLogging();
  }
#endif
  (void)stabilizerStep;
}

// What follows from the estimate to the motors.
#if MINIATURE_RELEASE >= 202608
static void fly(const stabilizerStep_t stabilizerStep) {
  static setpoint_t       tempSetpoint;
  static const setpoint_t nullSetpoint;

  const bool canFly = supervisorCanFly();
  crtpCommanderBlock(!canFly);

  // asked for in any case: it follows the vehicle
  const bool hasPlan = crtpCommanderHighLevelGetSetpoint(&tempSetpoint, &state, stabilizerStep);
  if (canFly && hasPlan) {
    commanderSetSetpoint(&tempSetpoint, COMMANDER_PRIORITY_HIGHLEVEL);
  }
  commanderGetSetpoint(&setpoint, &state);
  if (!canFly) {
    setpoint = nullSetpoint;
  }

  supervisorUpdate(&sensorData, &setpoint, stabilizerStep);
  collisionAvoidanceUpdateSetpoint(&setpoint, &sensorData, &state, stabilizerStep);
  supervisorOverrideSetpoint(&setpoint);

  controller(&control, &setpoint, &sensorData, &state, stabilizerStep);
  if (supervisorAreMotorsAllowedToRun()) {
    controlMotors(&control);
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT
    motorsBurstDshot();
#endif
  } else {
    motorsStop();
  }
}
#else
static void fly(const stabilizerStep_t stabilizerStep) {
  static setpoint_t tempSetpoint;

  // as an earlier step decided
  const bool areMotorsAllowedToRun = supervisorAreMotorsAllowedToRun();
  crtpCommanderBlock(!areMotorsAllowedToRun);

  if (crtpCommanderHighLevelGetSetpoint(&tempSetpoint, &state, stabilizerStep)) {
    commanderSetSetpoint(&tempSetpoint, COMMANDER_PRIORITY_HIGHLEVEL);
  }
  commanderGetSetpoint(&setpoint, &state);

  supervisorUpdate(&sensorData, &setpoint, stabilizerStep);
  collisionAvoidanceUpdateSetpoint(&setpoint, &sensorData, &state, stabilizerStep);
  supervisorOverrideSetpoint(&setpoint);

  controller(&control, &setpoint, &sensorData, &state, stabilizerStep);
  if (areMotorsAllowedToRun) {
    controlMotors(&control);
  } else {
    motorsStop();
  }
}
#endif

static void acquireSensors(void) {
#if MINIATURE_RELEASE >= 202502
  sensorsAcquire(&sensorData);
#else
  sensorsAcquire(&sensorData, xTaskGetTickCount());
#endif
}

static void stabilizerTask(void *param) {
  stabilizerStep_t stabilizerStep;
  uint32_t         lastWakeTime;
  (void)param;

  vTaskSetApplicationTaskTag(0, (void *)TASK_STABILIZER_ID_NBR);
  systemWaitStart();

  DEBUG_PRINT("Wait for sensor calibration...\n");
  lastWakeTime = xTaskGetTickCount();
  while (!sensorsAreCalibrated()) {
    vTaskDelayUntil(&lastWakeTime, F2T(RATE_MAIN_LOOP));
  }
  // not 0: whatever is done at a rate would be done at once
  stabilizerStep = 1;

#if MINIATURE_RELEASE >= 202512
  xRateSupervisorSemaphore = xSemaphoreCreateBinary();
  STATIC_MEM_TASK_CREATE(rateSupervisorTask, rateSupervisorTask, RATE_SUPERVISOR_TASK_NAME, NULL,
                         RATE_SUPERVISOR_TASK_PRI);

  // the last of those that the sensors were calibrated with
  sensorsWaitDataReady();
#else
  rateSupervisorInit(&rateSupervisorContext, xTaskGetTickCount(), M2T(1000), 997, 1003, 1);
#endif

  DEBUG_PRINT("Starting stabilizer loop\n");
  while (true) {
    sensorsWaitDataReady();
    acquireSensors();

    if (healthShallWeRunTest()) {
      healthRunTests(&sensorData);
    } else {
      updateStateEstimatorAndControllerTypes();
      stateEstimator(&state, stabilizerStep);
      fly(stabilizerStep);

      compressState();
      compressSetpoint();
      logUsd(stabilizerStep);
      calcSensorToOutputLatency(&sensorData);
      stabilizerStep++;
      STATS_CNT_RATE_EVENT(&stabilizerRate);
    }

#if MINIATURE_RELEASE >= 202512
    xSemaphoreGive(xRateSupervisorSemaphore);
#else
    if (!rateSupervisorValidate(&rateSupervisorContext, xTaskGetTickCount()) &&
        !rateWarningDisplayed) {
      DEBUG_PRINT("WARNING: stabilizer loop rate is off (%lu)\n",
                  (unsigned long)rateSupervisorLatestCount(&rateSupervisorContext));
      rateWarningDisplayed = true;
    }
#endif
#if MINIATURE_RELEASE >= 202608
#else
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT
    motorsBurstDshot();
#endif
#endif
  }
}

#if MINIATURE_RELEASE >= 202512
static void rateSupervisorTask(void *param) {
  (void)param;
  rateSupervisorInit(&rateSupervisorContext, xTaskGetTickCount(), M2T(1000), 997, 1003, 1);

  while (true) {
    // a loop that stands still is an error
    ASSERT(xSemaphoreTake(xRateSupervisorSemaphore, M2T(2000)) == pdTRUE);
    if (!rateSupervisorValidate(&rateSupervisorContext, xTaskGetTickCount()) &&
        !rateWarningDisplayed) {
      DEBUG_PRINT("WARNING: stabilizer loop rate is off (%lu)\n",
                  (unsigned long)rateSupervisorLatestCount(&rateSupervisorContext));
      rateWarningDisplayed = true;
    }
  }
}

#endif
PARAM_GROUP_START(stabilizer)
PARAM_ADD_CORE(PARAM_UINT8, estimator, &estimatorType)
PARAM_ADD_CORE(PARAM_UINT8, controller, &controllerType)
PARAM_GROUP_STOP(stabilizer)

LOG_GROUP_START(ctrltarget)
LOG_ADD_CORE(LOG_FLOAT, x, &setpoint.position.x)
LOG_ADD_CORE(LOG_FLOAT, y, &setpoint.position.y)
LOG_ADD_CORE(LOG_FLOAT, z, &setpoint.position.z)
LOG_ADD_CORE(LOG_FLOAT, vx, &setpoint.velocity.x)
LOG_ADD_CORE(LOG_FLOAT, vy, &setpoint.velocity.y)
LOG_ADD_CORE(LOG_FLOAT, vz, &setpoint.velocity.z)
LOG_ADD_CORE(LOG_FLOAT, ax, &setpoint.acceleration.x)
LOG_ADD_CORE(LOG_FLOAT, ay, &setpoint.acceleration.y)
LOG_ADD_CORE(LOG_FLOAT, az, &setpoint.acceleration.z)
LOG_ADD_CORE(LOG_FLOAT, roll, &setpoint.attitude.roll)
LOG_ADD_CORE(LOG_FLOAT, pitch, &setpoint.attitude.pitch)
LOG_ADD_CORE(LOG_FLOAT, yaw, &setpoint.attitudeRate.yaw)
#if MINIATURE_RELEASE >= 202608
LOG_ADD(LOG_UINT8, mode_x, &setpoint.mode.x)
LOG_ADD(LOG_UINT8, mode_y, &setpoint.mode.y)
LOG_ADD(LOG_UINT8, mode_z, &setpoint.mode.z)
LOG_ADD(LOG_UINT8, mode_roll, &setpoint.mode.roll)
LOG_ADD(LOG_UINT8, mode_pitch, &setpoint.mode.pitch)
LOG_ADD(LOG_UINT8, mode_yaw, &setpoint.mode.yaw)
LOG_ADD(LOG_UINT8, mode_quat, &setpoint.mode.quat)
#endif
LOG_GROUP_STOP(ctrltarget)

LOG_GROUP_START(ctrltargetZ)
LOG_ADD(LOG_INT16, x, &setpointCompressed.x)
LOG_ADD(LOG_INT16, y, &setpointCompressed.y)
LOG_ADD(LOG_INT16, z, &setpointCompressed.z)
LOG_ADD(LOG_INT16, vx, &setpointCompressed.vx)
LOG_ADD(LOG_INT16, vy, &setpointCompressed.vy)
LOG_ADD(LOG_INT16, vz, &setpointCompressed.vz)
LOG_ADD(LOG_INT16, ax, &setpointCompressed.ax)
LOG_ADD(LOG_INT16, ay, &setpointCompressed.ay)
LOG_ADD(LOG_INT16, az, &setpointCompressed.az)
LOG_GROUP_STOP(ctrltargetZ)

LOG_GROUP_START(stabilizer)
LOG_ADD(LOG_FLOAT, roll, &state.attitude.roll)
LOG_ADD(LOG_FLOAT, pitch, &state.attitude.pitch)
LOG_ADD(LOG_FLOAT, yaw, &state.attitude.yaw)
LOG_ADD(LOG_FLOAT, thrust, &control.thrust)
STATS_CNT_RATE_LOG_ADD(rtStab, &stabilizerRate)
LOG_ADD(LOG_UINT32, intToOut, &inToOutLatency)
LOG_GROUP_STOP(stabilizer)

LOG_GROUP_START(acc)
LOG_ADD_CORE(LOG_FLOAT, x, &sensorData.acc.x)
LOG_ADD_CORE(LOG_FLOAT, y, &sensorData.acc.y)
LOG_ADD_CORE(LOG_FLOAT, z, &sensorData.acc.z)
LOG_GROUP_STOP(acc)

#ifdef LOG_SEC_IMU
LOG_GROUP_START(accSec)
LOG_ADD(LOG_FLOAT, x, &sensorData.accSec.x)
LOG_ADD(LOG_FLOAT, y, &sensorData.accSec.y)
LOG_ADD(LOG_FLOAT, z, &sensorData.accSec.z)
LOG_GROUP_STOP(accSec)

LOG_GROUP_START(gyroSec)
LOG_ADD(LOG_FLOAT, x, &sensorData.gyroSec.x)
LOG_ADD(LOG_FLOAT, y, &sensorData.gyroSec.y)
LOG_ADD(LOG_FLOAT, z, &sensorData.gyroSec.z)
LOG_GROUP_STOP(gyroSec)
#endif

LOG_GROUP_START(baro)
LOG_ADD_CORE(LOG_FLOAT, asl, &sensorData.baro.asl)
LOG_ADD_CORE(LOG_FLOAT, temp, &sensorData.baro.temperature)
LOG_ADD_CORE(LOG_FLOAT, pressure, &sensorData.baro.pressure)
LOG_GROUP_STOP(baro)

LOG_GROUP_START(gyro)
LOG_ADD_CORE(LOG_FLOAT, x, &sensorData.gyro.x)
LOG_ADD_CORE(LOG_FLOAT, y, &sensorData.gyro.y)
LOG_ADD_CORE(LOG_FLOAT, z, &sensorData.gyro.z)
LOG_GROUP_STOP(gyro)

LOG_GROUP_START(mag)
LOG_ADD_CORE(LOG_FLOAT, x, &sensorData.mag.x)
LOG_ADD_CORE(LOG_FLOAT, y, &sensorData.mag.y)
LOG_ADD_CORE(LOG_FLOAT, z, &sensorData.mag.z)
LOG_GROUP_STOP(mag)

LOG_GROUP_START(controller)
LOG_ADD(LOG_INT16, ctr_yaw, &control.yaw)
LOG_GROUP_STOP(controller)

LOG_GROUP_START(stateEstimate)
LOG_ADD_CORE(LOG_FLOAT, x, &state.position.x)
LOG_ADD_CORE(LOG_FLOAT, y, &state.position.y)
LOG_ADD_CORE(LOG_FLOAT, z, &state.position.z)
LOG_ADD_CORE(LOG_FLOAT, vx, &state.velocity.x)
LOG_ADD_CORE(LOG_FLOAT, vy, &state.velocity.y)
LOG_ADD_CORE(LOG_FLOAT, vz, &state.velocity.z)
LOG_ADD_CORE(LOG_FLOAT, ax, &state.acc.x)
LOG_ADD_CORE(LOG_FLOAT, ay, &state.acc.y)
LOG_ADD_CORE(LOG_FLOAT, az, &state.acc.z)
LOG_ADD_CORE(LOG_FLOAT, roll, &state.attitude.roll)
LOG_ADD_CORE(LOG_FLOAT, pitch, &state.attitude.pitch)
LOG_ADD_CORE(LOG_FLOAT, yaw, &state.attitude.yaw)
LOG_ADD_CORE(LOG_FLOAT, qx, &state.attitudeQuaternion.x)
LOG_ADD_CORE(LOG_FLOAT, qy, &state.attitudeQuaternion.y)
LOG_ADD_CORE(LOG_FLOAT, qz, &state.attitudeQuaternion.z)
LOG_ADD_CORE(LOG_FLOAT, qw, &state.attitudeQuaternion.w)
LOG_GROUP_STOP(stateEstimate)

LOG_GROUP_START(stateEstimateZ)
LOG_ADD(LOG_INT16, x, &stateCompressed.x)
LOG_ADD(LOG_INT16, y, &stateCompressed.y)
LOG_ADD(LOG_INT16, z, &stateCompressed.z)
LOG_ADD(LOG_INT16, vx, &stateCompressed.vx)
LOG_ADD(LOG_INT16, vy, &stateCompressed.vy)
LOG_ADD(LOG_INT16, vz, &stateCompressed.vz)
LOG_ADD(LOG_INT16, ax, &stateCompressed.ax)
LOG_ADD(LOG_INT16, ay, &stateCompressed.ay)
LOG_ADD(LOG_INT16, az, &stateCompressed.az)
LOG_ADD(LOG_UINT32, quat, &stateCompressed.quat)
LOG_ADD(LOG_INT16, rateRoll, &stateCompressed.rateRoll)
LOG_ADD(LOG_INT16, ratePitch, &stateCompressed.ratePitch)
LOG_ADD(LOG_INT16, rateYaw, &stateCompressed.rateYaw)
LOG_GROUP_STOP(stateEstimateZ)

LOG_GROUP_START(motor)
LOG_ADD(LOG_INT32, m1req, &motorThrustBatCompUncapped.motors.m1)
LOG_ADD(LOG_INT32, m2req, &motorThrustBatCompUncapped.motors.m2)
LOG_ADD(LOG_INT32, m3req, &motorThrustBatCompUncapped.motors.m3)
LOG_ADD(LOG_INT32, m4req, &motorThrustBatCompUncapped.motors.m4)
LOG_GROUP_STOP(motor)
