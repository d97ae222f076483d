#ifndef CRTP_COMMANDER_H_
#define CRTP_COMMANDER_H_

#include <stdbool.h>
#include <stdint.h>

#include "crtp.h"
#include "stabilizer_types.h"

void crtpCommanderInit(void);
void crtpCommanderRpytDecodeSetpoint(setpoint_t *setpoint, CRTPPacket *pk);
void crtpCommanderGenericDecodeSetpoint(setpoint_t *setpoint, CRTPPacket *pk);

float getCPPMRollScale(void);
float getCPPMRollRateScale(void);
float getCPPMPitchScale(void);
float getCPPMPitchRateScale(void);
float getCPPMYawRateScale(void);

#endif  // CRTP_COMMANDER_H_
