/* The driver of the sensors, as far as the loop and the tests of health ask it: our front end did
 * the work (onboard/sensors.h), and hands over what it came to. */
#include "bitcraze/system/system.h"

#include "sensors.h"

#include "bitcraze/rtos/kernel.h"

cf_system_sensors_t cf_system_sensors;

void sensorsInit(void) {
}

bool sensorsTest(void) {
  return true;
}

bool sensorsManufacturingTest(void) {
  return true;
}

bool sensorsAreCalibrated(void) {
  return cf_system_sensors.are_calibrated;
}

void sensorsWaitDataReady(void) {
  cf_rtos_wait_data_ready();
}

#if HAVE_SENSORS_ACQUIRE_TICK
void sensorsAcquire(sensorData_t *sensors, const uint32_t tick CF_UNUSED) {
#else
void sensorsAcquire(sensorData_t *sensors) {
#endif
  *sensors = cf_system_sensors.data;
}

bool sensorsReadGyro(Axis3f *gyro) {
  *gyro = cf_system_sensors.data.gyro;
  return true;
}

bool sensorsReadAcc(Axis3f *acc) {
  *acc = cf_system_sensors.data.acc;
  return true;
}

bool sensorsReadMag(Axis3f *mag) {
  *mag = cf_system_sensors.data.mag;
  return false;
}

bool sensorsReadBaro(baro_t *baro) {
  *baro = cf_system_sensors.data.baro;
  return true;
}

void sensorsSetAccMode(accModes mode CF_UNUSED) {
}
