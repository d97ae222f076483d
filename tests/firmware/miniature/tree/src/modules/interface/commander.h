#ifndef COMMANDER_H_
#define COMMANDER_H_

#include "config.h"
#include "stabilizer_types.h"

void commanderSetSetpoint(setpoint_t *setpoint, int priority);

#endif  // COMMANDER_H_
