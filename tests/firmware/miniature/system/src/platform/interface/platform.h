#ifndef __PLATFORM_H__
#define __PLATFORM_H__

#include <stdbool.h>
#include <stdint.h>

#include "motors.h"
#include "stm32f4xx_gpio.h"

typedef enum {
  SensorImplementation_bmi088_bmp3xx,
  SensorImplementation_COUNT,
} SensorImplementation_t;

int                    platformInit(void);
const char            *platformConfigGetDeviceTypeName(void);
SensorImplementation_t platformConfigGetSensorImplementation(void);
const MotorPerifDef  **platformConfigGetMotorMapping(void);

#endif  // __PLATFORM_H__
