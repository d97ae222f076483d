/* The firmware's PID block, with its names (docs/reference/control-pid.md#6).
 *
 * The derivative acts on the measurement, the integral never stops (it is only limited), and both
 * limits read 0 as "none". The gains are members so that a written parameter acts at the next
 * update. */
#ifndef PID_H
#define PID_H

#include <stdbool.h>

#include "api/filter.h"

typedef struct {
  float desired;       // what the measurement should become
  float error;         // of the last update, wrapped for a yaw angle
  float prevMeasured;  // measurement of the last update
  float integ;         // integral of the error
  float deriv;         // -d(measurement)/dt, filtered when enableDFilter is set

  float kp;
  float ki;
  float kd;
  float kff;

  float outP;   // kp * error
  float outI;   // ki * integ
  float outD;   // kd * deriv
  float outFF;  // kff * desired

  float iLimit;       // bound of |integ|, 0 for none
  float outputLimit;  // bound of the absolute output, 0 for none
  float dt;           // [s] between updates

  lpf2pData dFilter;
  bool      enableDFilter;
} PidObject;

// Sets gains, dt [s] and the derivative filter (sample rate and cutoff in Hz); clears the memory,
// sets the integral limit to 5000 and lifts the output limit. The out* members keep their values.
void pidInit(PidObject *pid, float desired, float kp, float ki, float kd, float kff, float dt,
             float samplingRate, float cutoffFreq, bool enableDFilter);

// Clears error, integral and derivative and takes `initial` as the last measurement, so that the
// next derivative sees only what has changed since. The filter keeps its memory.
void pidReset(PidObject *pid, float initial);

// Returns the output for one measurement. `isYawAngle`: the quantity is an angle in degrees, so
// error and measured change are taken the short way round (once: both angles lie in [-180, 180]).
float pidUpdate(PidObject *pid, float measured, bool isYawAngle);

void  pidSetIntegralLimit(PidObject *pid, float limit);
void  pidSetDesired(PidObject *pid, float desired);
float pidGetDesired(const PidObject *pid);

// Returns false only if kp, ki and kd are all below 0.0001.
bool pidIsActive(const PidObject *pid);

void pidSetKp(PidObject *pid, float kp);
void pidSetKi(PidObject *pid, float ki);
void pidSetKd(PidObject *pid, float kd);
void pidSetKff(PidObject *pid, float kff);
void pidSetDt(PidObject *pid, float dt);

// Switches the derivative filter on or off; when on, it starts from zero with these frequencies
// [Hz].
void filterReset(PidObject *pid, float samplingRate, float cutoffFreq, bool enableDFilter);

#endif  // PID_H
