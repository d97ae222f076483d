#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "stabilizer_types.h"

void supervisorUpdate(const sensorData_t *sensors, const setpoint_t *setpoint,
                      stabilizerStep_t stabilizerStep);
void supervisorOverrideSetpoint(setpoint_t *setpoint);

bool supervisorCanFly(void);
bool supervisorIsFlying(void);
bool supervisorIsTumbled(void);
bool supervisorCanArm(void);
bool supervisorIsArmed(void);
bool supervisorIsLocked(void);
bool supervisorIsCrashed(void);
bool supervisorAreMotorsAllowedToRun(void);

// False when the present state does not allow it.
bool supervisorRequestArming(const bool doArm);
bool supervisorRequestCrashRecovery(const bool doRecovery);

#if MINIATURE_RELEASE >= 202608
// From port 9: stops until a reboot; the second one from then on unless it comes once per second.
void supervisorRequestEmergencyStop(void);
void supervisorNotifyEmergencyStopWatchdog(void);

#endif
// As in the log supervisor.info.
uint16_t supervisorGetInfoBitfield(void);
