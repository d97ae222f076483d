#ifndef ATTITUDE_CONTROLLER_H_
#define ATTITUDE_CONTROLLER_H_

#include <stdbool.h>
#include <stdint.h>

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

#if MINIATURE_RELEASE >= 202502
void attitudeControllerResetRollAttitudePID(float rollActual);
void attitudeControllerResetPitchAttitudePID(float pitchActual);
void attitudeControllerResetYawAttitudePID(float yawActual);
void attitudeControllerResetAllPID(float rollActual, float pitchActual, float yawActual);
#else
void attitudeControllerResetRollAttitudePID(void);
void attitudeControllerResetPitchAttitudePID(void);
void attitudeControllerResetAllPID(void);
#endif

void attitudeControllerGetActuatorOutput(int16_t *roll, int16_t *pitch, int16_t *yaw);
#if MINIATURE_RELEASE >= 202502
float attitudeControllerGetYawMaxDelta(void);
#endif

#endif /* ATTITUDE_CONTROLLER_H_ */
