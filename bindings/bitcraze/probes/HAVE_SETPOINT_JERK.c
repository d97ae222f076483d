// A setpoint has jerk.
#include "stabilizer_types.h"

float jerk_of(const setpoint_t *setpoint);
float jerk_of(const setpoint_t *setpoint) {
  return setpoint->jerk.x;
}
