// The firmware's attitude_controller.h for apps: attitude and rate loops of the PID controller of
// the same drone [deg, deg/s]. Null pointers are not allowed.
#ifndef CF_APP_ATTITUDE_CONTROLLER_H
#define CF_APP_ATTITUDE_CONTROLLER_H

#include <stdbool.h>
#include <stdint.h>

#include "stabilizer_types.h"

#define ATTITUDE_UPDATE_DT (float)(1.0f / ATTITUDE_RATE)  // [s]

// Nothing, since the loops are ready from boot on; the firmware initializes them once as well.
void attitudeControllerInit(const float updateDt);
bool attitudeControllerTest(void);

void attitudeControllerCorrectAttitudePID(float eulerRollActual, float eulerPitchActual,
                                          float eulerYawActual, float eulerRollDesired,
                                          float eulerPitchDesired, float eulerYawDesired,
                                          float *rollRateDesired, float *pitchRateDesired,
                                          float *yawRateDesired);
void attitudeControllerCorrectRatePID(float rollRateActual, float pitchRateActual,
                                      float yawRateActual, float rollRateDesired,
                                      float pitchRateDesired, float yawRateDesired);

void attitudeControllerResetRollAttitudePID(float rollActual);
void attitudeControllerResetPitchAttitudePID(float pitchActual);
void attitudeControllerResetAllPID(float rollActual, float pitchActual, float yawActual);

void  attitudeControllerGetActuatorOutput(int16_t *roll, int16_t *pitch, int16_t *yaw);
float attitudeControllerGetYawMaxDelta(void);

#endif  // CF_APP_ATTITUDE_CONTROLLER_H
