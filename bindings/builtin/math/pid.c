#include "api/pid.h"

#include <math.h>

#include "api/num.h"

#define DEFAULT_INTEGRAL_LIMIT 5000.0f
#define DEFAULT_OUTPUT_LIMIT 0.0f
#define ACTIVE_GAIN 0.0001f  // a gain below does not count

void pidInit(PidObject *pid, float desired, float kp, float ki, float kd, float kff, float dt,
             float samplingRate, float cutoffFreq, bool enableDFilter) {
  pid->desired      = desired;
  pid->error        = 0.0f;
  pid->prevMeasured = 0.0f;
  pid->integ        = 0.0f;
  pid->deriv        = 0.0f;

  pid->kp  = kp;
  pid->ki  = ki;
  pid->kd  = kd;
  pid->kff = kff;

  pid->iLimit      = DEFAULT_INTEGRAL_LIMIT;
  pid->outputLimit = DEFAULT_OUTPUT_LIMIT;
  pid->dt          = dt;

  filterReset(pid, samplingRate, cutoffFreq, enableDFilter);
}

void pidReset(PidObject *pid, float initial) {
  pid->error        = 0.0f;
  pid->prevMeasured = initial;
  pid->integ        = 0.0f;
  pid->deriv        = 0.0f;
}

// one turn, the short way round
static float wrap_once(float angle) {
  if (angle > 180.0f) {
    return angle - 360.0f;
  }
  if (angle < -180.0f) {
    return angle + 360.0f;
  }
  return angle;
}

// -d(measurement)/dt, filtered on request; what is not a number counts as no change
static float derivative(PidObject *pid, float measured, bool isYawAngle) {
  float delta = -(measured - pid->prevMeasured);
  if (isYawAngle) {
    delta = wrap_once(delta);
  }

  const float rate  = delta / pid->dt;
  const float deriv = pid->enableDFilter ? lpf2pApply(&pid->dFilter, rate) : rate;
  return isnan(deriv) ? 0.0f : deriv;
}

float pidUpdate(PidObject *pid, float measured, bool isYawAngle) {
  float output = 0.0f;

  pid->error = pid->desired - measured;
  if (isYawAngle) {
    pid->error = wrap_once(pid->error);
  }
  pid->outP = pid->kp * pid->error;
  output += pid->outP;

  pid->deriv = derivative(pid, measured, isYawAngle);
  pid->outD  = pid->kd * pid->deriv;
  output += pid->outD;

  pid->integ += pid->error * pid->dt;
  if (pid->iLimit != 0.0f) {
    pid->integ = constrain(pid->integ, -pid->iLimit, pid->iLimit);
  }
  pid->outI = pid->ki * pid->integ;
  output += pid->outI;

  pid->outFF = pid->kff * pid->desired;
  output += pid->outFF;

  if (pid->outputLimit != 0.0f) {
    output = constrain(output, -pid->outputLimit, pid->outputLimit);
  }

  pid->prevMeasured = measured;
  return output;
}

void pidSetIntegralLimit(PidObject *pid, float limit) {
  pid->iLimit = limit;
}

void pidSetDesired(PidObject *pid, float desired) {
  pid->desired = desired;
}

float pidGetDesired(const PidObject *pid) {
  return pid->desired;
}

bool pidIsActive(const PidObject *pid) {
  return !(pid->kp < ACTIVE_GAIN && pid->ki < ACTIVE_GAIN && pid->kd < ACTIVE_GAIN);
}

void pidSetKp(PidObject *pid, float kp) {
  pid->kp = kp;
}

void pidSetKi(PidObject *pid, float ki) {
  pid->ki = ki;
}

void pidSetKd(PidObject *pid, float kd) {
  pid->kd = kd;
}

void pidSetKff(PidObject *pid, float kff) {
  pid->kff = kff;
}

void pidSetDt(PidObject *pid, float dt) {
  pid->dt = dt;
}

void filterReset(PidObject *pid, float samplingRate, float cutoffFreq, bool enableDFilter) {
  pid->enableDFilter = enableDFilter;
  if (enableDFilter) {
    lpf2pInit(&pid->dFilter, samplingRate, cutoffFreq);
  }
}
