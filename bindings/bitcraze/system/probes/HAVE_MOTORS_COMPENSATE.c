// The loop asks the driver of the motors to compensate the battery.
#include "motors.h"

float probe(uint32_t id, float thrust, float supply);
float probe(uint32_t id, float thrust, float supply) {
  return motorsCompensateBatteryVoltage(id, thrust, supply);
}
