// clang-format off
#include "stabilizer_types.h"

#include "attitude_controller.h"
#include "pid.h"
#include "param.h"
#include "log.h"
#include "commander.h"
#include "platform_defaults.h"
// clang-format on

static bool  attFiltEnable  = ATTITUDE_LPF_ENABLE;
static bool  rateFiltEnable = ATTITUDE_RATE_LPF_ENABLE;
static float attFiltCutoff  = ATTITUDE_LPF_CUTOFF_FREQ;
static float omxFiltCutoff  = ATTITUDE_ROLL_RATE_LPF_CUTOFF_FREQ;
static float omyFiltCutoff  = ATTITUDE_PITCH_RATE_LPF_CUTOFF_FREQ;
static float omzFiltCutoff  = ATTITUDE_YAW_RATE_LPF_CUTOFF_FREQ;
static float yawMaxDelta    = YAW_MAX_DELTA;

#define GAINS(axis) \
  {.kp = PID_##axis##_KP, .ki = PID_##axis##_KI, .kd = PID_##axis##_KD, .kff = PID_##axis##_KFF}

PidObject pidRollRate  = GAINS(ROLL_RATE);
PidObject pidPitchRate = GAINS(PITCH_RATE);
PidObject pidYawRate   = GAINS(YAW_RATE);
PidObject pidRoll      = GAINS(ROLL);
PidObject pidPitch     = GAINS(PITCH);
PidObject pidYaw       = GAINS(YAW);

static int16_t rollOutput;
static int16_t pitchOutput;
static int16_t yawOutput;

static bool isInit;

static void initPid(PidObject *pid, float dt, float limit, float cutoff, bool filtered) {
  pidInit(pid, 0, pid->kp, pid->ki, pid->kd, pid->kff, dt, ATTITUDE_RATE, cutoff, filtered);
  pidSetIntegralLimit(pid, limit);
}

void attitudeControllerInit(const float updateDt) {
  if (isInit) {
    return;
  }
  initPid(&pidRollRate, updateDt, PID_ROLL_RATE_INTEGRATION_LIMIT, omxFiltCutoff, rateFiltEnable);
  initPid(&pidPitchRate, updateDt, PID_PITCH_RATE_INTEGRATION_LIMIT, omyFiltCutoff, rateFiltEnable);
  initPid(&pidYawRate, updateDt, PID_YAW_RATE_INTEGRATION_LIMIT, omzFiltCutoff, rateFiltEnable);
  initPid(&pidRoll, updateDt, PID_ROLL_INTEGRATION_LIMIT, attFiltCutoff, attFiltEnable);
  initPid(&pidPitch, updateDt, PID_PITCH_INTEGRATION_LIMIT, attFiltCutoff, attFiltEnable);
  initPid(&pidYaw, updateDt, PID_YAW_INTEGRATION_LIMIT, attFiltCutoff, attFiltEnable);
  isInit = true;
}

bool attitudeControllerTest(void) {
  return isInit;
}

static float run(PidObject *pid, float actual, float desired, bool isYawAngle) {
  pidSetDesired(pid, desired);
  return pidUpdate(pid, actual, isYawAngle);
}

static int16_t saturateSignedInt16(float in) {
  if (in > INT16_MAX) {
    return INT16_MAX;
  }
  return in < -INT16_MAX ? -INT16_MAX : (int16_t)in;
}

void attitudeControllerCorrectAttitudePID(float eulerRollActual, float eulerPitchActual,
                                          float eulerYawActual, float eulerRollDesired,
                                          float eulerPitchDesired, float eulerYawDesired,
                                          float *rollRateDesired, float *pitchRateDesired,
                                          float *yawRateDesired) {
  *rollRateDesired  = run(&pidRoll, eulerRollActual, eulerRollDesired, false);
  *pitchRateDesired = run(&pidPitch, eulerPitchActual, eulerPitchDesired, false);
  *yawRateDesired   = run(&pidYaw, eulerYawActual, eulerYawDesired, true);
}

void attitudeControllerCorrectRatePID(float rollRateActual, float pitchRateActual,
                                      float yawRateActual, float rollRateDesired,
                                      float pitchRateDesired, float yawRateDesired) {
  rollOutput  = saturateSignedInt16(run(&pidRollRate, rollRateActual, rollRateDesired, false));
  pitchOutput = saturateSignedInt16(run(&pidPitchRate, pitchRateActual, pitchRateDesired, false));
  yawOutput   = saturateSignedInt16(run(&pidYawRate, yawRateActual, yawRateDesired, false));
}

#if MINIATURE_RELEASE >= 202502
void attitudeControllerResetRollAttitudePID(float rollActual) {
  pidReset(&pidRoll, rollActual);
}

void attitudeControllerResetPitchAttitudePID(float pitchActual) {
  pidReset(&pidPitch, pitchActual);
}

void attitudeControllerResetYawAttitudePID(float yawActual) {
  pidReset(&pidYaw, yawActual);
}

void attitudeControllerResetAllPID(float rollActual, float pitchActual, float yawActual) {
  pidReset(&pidRoll, rollActual);
  pidReset(&pidPitch, pitchActual);
  pidReset(&pidYaw, yawActual);
  pidReset(&pidRollRate, 0);
  pidReset(&pidPitchRate, 0);
  pidReset(&pidYawRate, 0);
}
#else
void attitudeControllerResetRollAttitudePID(void) {
  pidReset(&pidRoll);
}

void attitudeControllerResetPitchAttitudePID(void) {
  pidReset(&pidPitch);
}

void attitudeControllerResetAllPID(void) {
  pidReset(&pidRoll);
  pidReset(&pidPitch);
  pidReset(&pidYaw);
  pidReset(&pidRollRate);
  pidReset(&pidPitchRate);
  pidReset(&pidYawRate);
}
#endif

void attitudeControllerGetActuatorOutput(int16_t *roll, int16_t *pitch, int16_t *yaw) {
  *roll  = rollOutput;
  *pitch = pitchOutput;
  *yaw   = yawOutput;
}

#if MINIATURE_RELEASE >= 202502
float attitudeControllerGetYawMaxDelta(void) {
  return yawMaxDelta;
}
#endif

#define LOG_TERMS(axis, pid)                 \
  LOG_ADD(LOG_FLOAT, axis##_outP, &pid.outP) \
  LOG_ADD(LOG_FLOAT, axis##_outI, &pid.outI) \
  LOG_ADD(LOG_FLOAT, axis##_outD, &pid.outD) \
  LOG_ADD(LOG_FLOAT, axis##_outFF, &pid.outFF)

LOG_GROUP_START(pid_attitude)
LOG_TERMS(roll, pidRoll)
LOG_TERMS(pitch, pidPitch)
LOG_TERMS(yaw, pidYaw)
LOG_GROUP_STOP(pid_attitude)

LOG_GROUP_START(pid_rate)
LOG_TERMS(roll, pidRollRate)
LOG_TERMS(pitch, pidPitchRate)
LOG_TERMS(yaw, pidYawRate)
LOG_GROUP_STOP(pid_rate)

#define PARAM_GAINS(axis, pid)                                  \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##_kp, &pid.kp) \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##_ki, &pid.ki) \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##_kd, &pid.kd) \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##_kff, &pid.kff)

PARAM_GROUP_START(pid_attitude)
PARAM_GAINS(roll, pidRoll)
PARAM_GAINS(pitch, pidPitch)
PARAM_GAINS(yaw, pidYaw)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, yawMaxDelta, &yawMaxDelta)
PARAM_ADD(PARAM_INT8 | PARAM_PERSISTENT, attFiltEn, &attFiltEnable)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, attFiltCut, &attFiltCutoff)
PARAM_GROUP_STOP(pid_attitude)

PARAM_GROUP_START(pid_rate)
PARAM_GAINS(roll, pidRollRate)
PARAM_GAINS(pitch, pidPitchRate)
PARAM_GAINS(yaw, pidYawRate)
PARAM_ADD(PARAM_INT8 | PARAM_PERSISTENT, rateFiltEn, &rateFiltEnable)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, omxFiltCut, &omxFiltCutoff)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, omyFiltCut, &omyFiltCutoff)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, omzFiltCut, &omzFiltCutoff)
PARAM_GROUP_STOP(pid_rate)
