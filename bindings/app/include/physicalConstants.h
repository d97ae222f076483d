// The firmware's physicalConstants.h for apps (docs/reference/control-geometric.md#5).
#ifndef CF_APP_PHYSICAL_CONSTANTS_H
#define CF_APP_PHYSICAL_CONSTANTS_H

#include "api/math3d.h"

#define SPEED_OF_LIGHT (299792458.0)
#define GRAVITY_MAGNITUDE (9.81f)  // [m/s^2]
#define ARCMINUTE (M_PI_F / 10800.0f)

#endif  // CF_APP_PHYSICAL_CONSTANTS_H
