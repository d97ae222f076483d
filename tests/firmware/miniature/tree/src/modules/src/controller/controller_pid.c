
// clang-format off
#include "stabilizer_types.h"

#include "attitude_controller.h"
#include "position_controller.h"
#include "controller_pid.h"

#include "log.h"
#include "param.h"
#include "math3d.h"
#if MINIATURE_RELEASE >= 202608
#include <string.h>
#endif
// clang-format on

#define ATTITUDE_UPDATE_DT (float)(1.0f / ATTITUDE_RATE)

static attitude_t attitudeDesired;
static attitude_t rateDesired;
static float      actuatorThrust;

static float cmd_thrust;
static float cmd_roll;
static float cmd_pitch;
static float cmd_yaw;
static float r_roll;
static float r_pitch;
static float r_yaw;
static float accelz;

void controllerPidInit(void) {
  attitudeControllerInit(ATTITUDE_UPDATE_DT);
  positionControllerInit();
}

bool controllerPidTest(void) {
  return attitudeControllerTest();
}

static float capAngle(float angle) {
  float result = angle;
  while (result > 180.0f) {
    result -= 360.0f;
  }
  while (result < -180.0f) {
    result += 360.0f;
  }
  return result;
}

static void resetAll(const state_t *state) {
#if MINIATURE_RELEASE >= 202502
  positionControllerResetAllPID(state->position.x, state->position.y, state->position.z);
  attitudeControllerResetAllPID(state->attitude.roll, state->attitude.pitch, state->attitude.yaw);
#else
  (void)state;
  positionControllerResetAllPID();
  attitudeControllerResetAllPID();
#endif
#if MINIATURE_RELEASE >= 202608
  positionControllerResetAllfilters();
#endif
}

static void yawTarget(const setpoint_t *setpoint, const state_t *state) {
  if (setpoint->mode.yaw == modeVelocity) {
    attitudeDesired.yaw =
        capAngle(attitudeDesired.yaw + setpoint->attitudeRate.yaw * ATTITUDE_UPDATE_DT);
#if MINIATURE_RELEASE >= 202502
    const float yawMaxDelta = attitudeControllerGetYawMaxDelta();
    if (yawMaxDelta != 0.0f) {
      const float delta = capAngle(attitudeDesired.yaw - state->attitude.yaw);
      if (delta > yawMaxDelta) {
        attitudeDesired.yaw = state->attitude.yaw + yawMaxDelta;
      } else if (delta < -yawMaxDelta) {
        attitudeDesired.yaw = state->attitude.yaw - yawMaxDelta;
      }
    }
#endif
  } else if (setpoint->mode.yaw == modeAbs) {
    attitudeDesired.yaw = setpoint->attitude.yaw;
  } else if (setpoint->mode.quat == modeAbs) {
    const quaternion_t *q = &setpoint->attitudeQuaternion;
    attitudeDesired.yaw   = degrees(quat2rpy(mkquat(q->x, q->y, q->z, q->w)).z);
  }
  attitudeDesired.yaw = capAngle(attitudeDesired.yaw);
}

void controllerPid(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                   const state_t *state, const stabilizerStep_t stabilizerStep) {
  control->controlMode = controlModeLegacy;

#if MINIATURE_RELEASE >= 202608
  static setpoint_mode_t previousMode;
  if (memcmp(&setpoint->mode, &previousMode, sizeof previousMode) != 0) {
    resetAll(state);
    attitudeDesired.roll  = state->attitude.roll;
    attitudeDesired.pitch = state->attitude.pitch;
    previousMode          = setpoint->mode;
  }
#endif

  if (RATE_DO_EXECUTE(ATTITUDE_RATE, stabilizerStep)) {
    yawTarget(setpoint, state);
  }
  if (RATE_DO_EXECUTE(POSITION_RATE, stabilizerStep)) {
    positionController(&actuatorThrust, &attitudeDesired, setpoint, state);
  }
  if (RATE_DO_EXECUTE(ATTITUDE_RATE, stabilizerStep)) {
    if (setpoint->mode.z == modeDisable) {
      actuatorThrust = setpoint->thrust;
    }
    if (setpoint->mode.x == modeDisable || setpoint->mode.y == modeDisable) {
      attitudeDesired.roll  = setpoint->attitude.roll;
      attitudeDesired.pitch = setpoint->attitude.pitch;
    }
    attitudeControllerCorrectAttitudePID(state->attitude.roll, state->attitude.pitch,
                                         state->attitude.yaw, attitudeDesired.roll,
                                         attitudeDesired.pitch, attitudeDesired.yaw,
                                         &rateDesired.roll, &rateDesired.pitch, &rateDesired.yaw);
    if (setpoint->mode.roll == modeVelocity) {
      rateDesired.roll = setpoint->attitudeRate.roll;
    }
    if (setpoint->mode.pitch == modeVelocity) {
      rateDesired.pitch = setpoint->attitudeRate.pitch;
    }
    attitudeControllerCorrectRatePID(sensors->gyro.x, -sensors->gyro.y, sensors->gyro.z,
                                     rateDesired.roll, rateDesired.pitch, rateDesired.yaw);
    attitudeControllerGetActuatorOutput(&control->roll, &control->pitch, &control->yaw);
    control->yaw = -control->yaw;

    cmd_thrust = control->thrust;
    cmd_roll   = control->roll;
    cmd_pitch  = control->pitch;
    cmd_yaw    = control->yaw;
    r_roll     = radians(sensors->gyro.x);
    r_pitch    = -radians(sensors->gyro.y);
    r_yaw      = radians(sensors->gyro.z);
    accelz     = sensors->acc.z;
  }

  control->thrust = actuatorThrust;
  if (control->thrust == 0) {
    control->thrust = 0;
    control->roll   = 0;
    control->pitch  = 0;
    control->yaw    = 0;
    cmd_thrust      = control->thrust;
    cmd_roll        = control->roll;
    cmd_pitch       = control->pitch;
    cmd_yaw         = control->yaw;
    resetAll(state);
#if MINIATURE_RELEASE >= 202608
    attitudeDesired.roll  = state->attitude.roll;
    attitudeDesired.pitch = state->attitude.pitch;
#endif
    attitudeDesired.yaw = state->attitude.yaw;
  }
}

// PRECISE_LANDING Pid
LOG_GROUP_START(controller)
LOG_ADD(LOG_FLOAT, cmd_thrust, &cmd_thrust)
LOG_ADD(LOG_FLOAT, cmd_roll, &cmd_roll)
LOG_ADD(LOG_FLOAT, cmd_pitch, &cmd_pitch)
LOG_ADD(LOG_FLOAT, cmd_yaw, &cmd_yaw)
LOG_ADD(LOG_FLOAT, r_roll, &r_roll)
LOG_ADD(LOG_FLOAT, r_pitch, &r_pitch)
LOG_ADD(LOG_FLOAT, r_yaw, &r_yaw)
LOG_ADD(LOG_FLOAT, accelz, &accelz)
LOG_ADD(LOG_FLOAT, actuatorThrust, &actuatorThrust)
LOG_ADD(LOG_FLOAT, roll, &attitudeDesired.roll)
LOG_ADD(LOG_FLOAT, pitch, &attitudeDesired.pitch)
LOG_ADD(LOG_FLOAT, yaw, &attitudeDesired.yaw)
LOG_ADD(LOG_FLOAT, rollRate, &rateDesired.roll)
LOG_ADD(LOG_FLOAT, pitchRate, &rateDesired.pitch)
LOG_ADD(LOG_FLOAT, yawRate, &rateDesired.yaw)
LOG_GROUP_STOP(controller)
