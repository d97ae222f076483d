#ifndef POWER_DISTRIBUTION_H_
#define POWER_DISTRIBUTION_H_

#include "stabilizer_types.h"

void powerDistributionInit(void);
bool powerDistributionTest(void);
void powerDistribution(const control_t *control, motors_thrust_uncapped_t *motorThrustUncapped);
#if MINIATURE_RELEASE >= 202502
bool powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm);
#else
void powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm);
#endif
uint32_t powerDistributionGetIdleThrust(void);
#if MINIATURE_RELEASE >= 202608
float powerDistributionGetMaxThrust(void);
#endif
int      powerDistributionMotorType(uint32_t id);
uint16_t powerDistributionStopRatio(uint32_t id);

#endif  // POWER_DISTRIBUTION_H_
