// Samples of the sensors.
#ifndef __SENSORS_H__
#define __SENSORS_H__

#include "stabilizer_types.h"

typedef enum {
  ACC_MODE_PROPTEST,
  ACC_MODE_FLIGHT,
} accModes;

void sensorsInit(void);
bool sensorsTest(void);
bool sensorsAreCalibrated(void);
bool sensorsManufacturingTest(void);
#if MINIATURE_RELEASE >= 202502
void sensorsAcquire(sensorData_t *sensors);
#else
void sensorsAcquire(sensorData_t *sensors, const uint32_t tick);
#endif
void sensorsWaitDataReady(void);

bool sensorsReadGyro(Axis3f *gyro);
bool sensorsReadAcc(Axis3f *acc);
bool sensorsReadMag(Axis3f *mag);
bool sensorsReadBaro(baro_t *baro);
void sensorsSetAccMode(accModes accMode);
#if MINIATURE_RELEASE >= 202608
bool isSensorsSuspended(void);
#endif

#endif  // __SENSORS_H__
