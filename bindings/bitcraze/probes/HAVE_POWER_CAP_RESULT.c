// The cap tells whether it reduced.
#include "power_distribution.h"

bool (*const cap)(const motors_thrust_uncapped_t *, motors_thrust_pwm_t *) = powerDistributionCap;
