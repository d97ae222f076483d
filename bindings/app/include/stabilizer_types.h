// The firmware's stabilizer_types.h for apps.
#ifndef CF_APP_STABILIZER_TYPES_H
#define CF_APP_STABILIZER_TYPES_H

#include "api/stabilizer_types.h"

#define RATE_DO_EXECUTE(RATE_HZ, TICK) (((TICK) % (RATE_MAIN_LOOP / (RATE_HZ))) == 0)

#endif  // CF_APP_STABILIZER_TYPES_H
