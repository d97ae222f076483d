/* What the firmware's tasks did to the hardware that is not there. Part of the drone's image. */
#ifndef CF_BITCRAZE_RTOS_HARDWARE_H
#define CF_BITCRAZE_RTOS_HARDWARE_H

#include <stdint.h>

#define CF_HARDWARE_MOTORS 4

extern uint16_t cf_hardware_motors[CF_HARDWARE_MOTORS];  // ratios, 0 to 65535
extern float    cf_hardware_battery;                     // [V], set by the adapter

#endif  // CF_BITCRAZE_RTOS_HARDWARE_H
