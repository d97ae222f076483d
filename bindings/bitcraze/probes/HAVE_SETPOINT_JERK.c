// A setpoint has jerk.
#include "stabilizer_types.h"

float probe(const setpoint_t *setpoint);
float probe(const setpoint_t *setpoint) {
  return setpoint->jerk.x;
}
