// From what a controller asks for to what each motor gives.
#ifndef __POWER_DISTRIBUTION_H__
#define __POWER_DISTRIBUTION_H__

#include "stabilizer_types.h"

void powerDistributionInit(void);
bool powerDistributionTest(void);
void powerDistribution(const control_t *control, motors_thrust_uncapped_t *motorThrustUncapped);
#if MINIATURE_RELEASE >= 202512
bool powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm);
#else
void powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm);
#endif
uint32_t powerDistributionGetIdleThrust();
#if MINIATURE_RELEASE >= 202512
float powerDistributionGetMaxThrust();
#endif
int      powerDistributionMotorType(uint32_t id);
uint16_t powerDistributionStopRatio(uint32_t id);

#endif  // __POWER_DISTRIBUTION_H__
