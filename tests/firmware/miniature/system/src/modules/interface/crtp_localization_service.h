#ifndef CRTP_LOCALIZATION_SERVICE_H_
#define CRTP_LOCALIZATION_SERVICE_H_

#include <stdbool.h>
#include <stdint.h>

#include "crtp.h"
#include "stabilizer_types.h"
#ifdef CONFIG_DECK_LIGHTHOUSE
#include "lighthouse_types.h"
#endif

void locSrvInit(void);

bool     locSrvIsEmergencyStopRequested(void);
uint32_t locSrvGetEmergencyStopWatchdogNotificationTick(void);  // 0: never notified

#endif  // CRTP_LOCALIZATION_SERVICE_H_
