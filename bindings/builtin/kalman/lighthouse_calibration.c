#include "api/lighthouse_calibration.h"

#include <math.h>

static float clip_to_unit(float x) {
  if (x > 1.0f) {
    return 1.0f;
  }
  return x < -1.0f ? -1.0f : x;
}

float lighthouseCalibrationMeasurementModelLh2(const float x, const float y, const float z,
                                               const float                         t,
                                               const lighthouseCalibrationSweep_t *calib) {
  const float azimuth = atan2f(y, x);
  const float r       = sqrtf(x * x + y * y);
  const float base    = azimuth + asinf(clip_to_unit(z * tanf(t - calib->tilt) / r));

  return base - (calib->phase - calib->gibmag * cosf(azimuth + calib->gibphase));
}
