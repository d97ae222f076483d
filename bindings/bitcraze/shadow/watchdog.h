/* Replaces the header of the hardware watchdog, which a host does not have. */
#ifndef CF_BITCRAZE_WATCHDOG_H
#define CF_BITCRAZE_WATCHDOG_H

#include <stdbool.h>
#include <stdint.h>

#endif  // CF_BITCRAZE_WATCHDOG_H
