#include "bitcraze/measurement_conversion.h"

#include "bitcraze/conversions.h"

bool cf_checkout_measurement(measurement_t *to, const api_measurement_t *from,
                             lighthouseCalibrationSweep_t *calibration) {
  switch (from->type) {
    case api_MeasurementTypeTDOA:
      to->type      = MeasurementTypeTDOA;
      to->data.tdoa = cf_checkout_tdoa(&from->data.tdoa);
      return true;
    case api_MeasurementTypePosition:
      to->type          = MeasurementTypePosition;
      to->data.position = cf_checkout_position(&from->data.position);
      return true;
    case api_MeasurementTypePose:
      to->type      = MeasurementTypePose;
      to->data.pose = cf_checkout_pose(&from->data.pose);
      return true;
    case api_MeasurementTypeDistance:
      to->type          = MeasurementTypeDistance;
      to->data.distance = cf_checkout_distance(&from->data.distance);
      return true;
    case api_MeasurementTypeTOF:
      to->type     = MeasurementTypeTOF;
      to->data.tof = cf_checkout_tof(&from->data.tof);
      return true;
    case api_MeasurementTypeAbsoluteHeight:
      to->type        = MeasurementTypeAbsoluteHeight;
      to->data.height = cf_checkout_height(&from->data.height);
      return true;
    case api_MeasurementTypeFlow:
      to->type      = MeasurementTypeFlow;
      to->data.flow = cf_checkout_flow(&from->data.flow);
      return true;
    case api_MeasurementTypeYawError:
      to->type          = MeasurementTypeYawError;
      to->data.yawError = cf_checkout_yaw_error(&from->data.yawError);
      return true;
    case api_MeasurementTypeSweepAngle:
      to->type            = MeasurementTypeSweepAngle;
      to->data.sweepAngle = cf_checkout_sweep(&from->data.sweepAngle, calibration);
      return true;
    case api_MeasurementTypeGyroscope:
      to->type                = MeasurementTypeGyroscope;
      to->data.gyroscope.gyro = cf_checkout_axes(&from->data.gyroscope.gyro);
      return true;
    case api_MeasurementTypeAcceleration:
      to->type                  = MeasurementTypeAcceleration;
      to->data.acceleration.acc = cf_checkout_axes(&from->data.acceleration.acc);
      return true;
    case api_MeasurementTypeBarometer:
      to->type                = MeasurementTypeBarometer;
      to->data.barometer.baro = cf_checkout_baro(&from->data.barometer.baro);
      return true;
    default:
      return false;
  }
}
