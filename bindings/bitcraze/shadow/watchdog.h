/* Stands in for the header of the watchdog, which nobody has to feed on a host. */
#ifndef CF_BITCRAZE_WATCHDOG_H
#define CF_BITCRAZE_WATCHDOG_H

#include <stdbool.h>
#include <stdint.h>

#endif  // CF_BITCRAZE_WATCHDOG_H
