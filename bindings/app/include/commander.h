/* The firmware's commander.h for apps: names of priorities. The commander itself is beyond the
 * reach of code that the loop calls: what it decided comes as the setpoint. */
#ifndef CF_APP_COMMANDER_H
#define CF_APP_COMMANDER_H

#include "stabilizer_types.h"

#define COMMANDER_PRIORITY_DISABLE 0
#define COMMANDER_PRIORITY_LOWEST 1
#define COMMANDER_PRIORITY_HIGHLEVEL 1
#define COMMANDER_PRIORITY_CRTP 2
#define COMMANDER_PRIORITY_EXTRX 3

#endif  // CF_APP_COMMANDER_H
