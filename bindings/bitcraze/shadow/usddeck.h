/* Stands in for the header of the SD card deck. The modules use it with CONFIG_DECK_USD only, which
 * is not set on a host. */
#ifndef CF_BITCRAZE_USDDECK_H
#define CF_BITCRAZE_USDDECK_H

#include <stdbool.h>
#include <stdint.h>

#endif  // CF_BITCRAZE_USDDECK_H
