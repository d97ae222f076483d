// A range comes with the angle of the sensor's cone.
#include "stabilizer_types.h"

float probe(const tofMeasurement_t *tof);
float probe(const tofMeasurement_t *tof) {
  return tof->coneHalfAngle;
}
