#ifndef __I2CDEV_H__
#define __I2CDEV_H__

#include "i2c_drv.h"

typedef I2cDrv I2C_Dev;

int i2cdevInit(I2C_Dev *dev);

#endif  // __I2CDEV_H__
