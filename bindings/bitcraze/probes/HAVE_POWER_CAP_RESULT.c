// The cap tells whether it reduced.
#include "power_distribution.h"

bool probe(motors_thrust_uncapped_t *uncapped, motors_thrust_pwm_t *capped);
bool probe(motors_thrust_uncapped_t *uncapped, motors_thrust_pwm_t *capped) {
  return powerDistributionCap(uncapped, capped);
}
