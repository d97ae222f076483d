/* What waits in the queue of the estimator (estimators dossier section 3.4).
 *
 * The enumerators are those of the firmware; the union has the members of the measurement models
 * that exist here. */
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
    positionMeasurement_t     position;
    poseMeasurement_t         pose;
    tofMeasurement_t          tof;
    flowMeasurement_t         flow;
    gyroscopeMeasurement_t    gyroscope;
    accelerationMeasurement_t acceleration;
    barometerMeasurement_t    barometer;
  } data;
} measurement_t;

#endif  // MEASUREMENT_H
