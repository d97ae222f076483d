// A range comes with the angle of the sensor's cone.
#include "stabilizer_types.h"

float cone_of(const tofMeasurement_t *tof);
float cone_of(const tofMeasurement_t *tof) {
  return tof->coneHalfAngle;
}
