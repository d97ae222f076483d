/* Stands in for the header of the I2C driver: nothing on a host is connected to it. */
#ifndef CF_BITCRAZE_I2CDEV_H
#define CF_BITCRAZE_I2CDEV_H

#include <stdbool.h>
#include <stdint.h>

#endif  // CF_BITCRAZE_I2CDEV_H
