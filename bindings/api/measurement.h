/* What waits in the queue of the estimator (docs/reference/estimators.md#3.4). */
#ifndef MEASUREMENT_H
#define MEASUREMENT_H

#include "api/stabilizer_types.h"

typedef enum {
  MeasurementTypeTDOA           = 0,
  MeasurementTypePosition       = 1,
  MeasurementTypePose           = 2,
  MeasurementTypeDistance       = 3,
  MeasurementTypeTOF            = 4,
  MeasurementTypeAbsoluteHeight = 5,
  MeasurementTypeFlow           = 6,
  MeasurementTypeYawError       = 7,
  MeasurementTypeSweepAngle     = 8,
  MeasurementTypeGyroscope      = 9,
  MeasurementTypeAcceleration   = 10,
  MeasurementTypeBarometer      = 11,
} MeasurementType;

typedef struct {
  MeasurementType type;
  union {
    tdoaMeasurement_t         tdoa;
    positionMeasurement_t     position;
    poseMeasurement_t         pose;
    distanceMeasurement_t     distance;
    tofMeasurement_t          tof;
    heightMeasurement_t       height;
    flowMeasurement_t         flow;
    yawErrorMeasurement_t     yawError;
    sweepAngleMeasurement_t   sweepAngle;
    gyroscopeMeasurement_t    gyroscope;
    accelerationMeasurement_t acceleration;
    barometerMeasurement_t    barometer;
  } data;
} measurement_t;

#endif  // MEASUREMENT_H
