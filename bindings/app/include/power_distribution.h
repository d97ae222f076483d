// The firmware's power_distribution.h for apps: the mixer of the same drone.
#ifndef CF_APP_POWER_DISTRIBUTION_H
#define CF_APP_POWER_DISTRIBUTION_H

#include <stdbool.h>
#include <stdint.h>

#include "stabilizer_types.h"

void     powerDistributionInit(void);
bool     powerDistributionTest(void);
void     powerDistribution(const control_t *control, motors_thrust_uncapped_t *motorThrustUncapped);
bool     powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                              motors_thrust_pwm_t            *motorPwm);
int      powerDistributionMotorType(uint32_t id);
uint16_t powerDistributionStopRatio(uint32_t id);
uint32_t powerDistributionGetIdleThrust(void);
float    powerDistributionGetMaxThrust(void);  // [N], of the four motors together

#endif  // CF_APP_POWER_DISTRIBUTION_H
