/* Stands in for the header of the vehicle's platform. */
#ifndef CF_BITCRAZE_PLATFORM_H
#define CF_BITCRAZE_PLATFORM_H

#include <stdbool.h>
#include <stdint.h>

// Null: there is no map. Whatever type motorsInit() of the checkout wants.
void       *platformConfigGetMotorMapping(void);
const char *platformConfigGetDeviceTypeName(void);

#endif  // CF_BITCRAZE_PLATFORM_H
