/* A measurement of ours as one of the checkout, whatever it is of. */
#ifndef CF_BITCRAZE_MEASUREMENT_CONVERSION_H
#define CF_BITCRAZE_MEASUREMENT_CONVERSION_H

#include "bitcraze/checkout.h"

#include "estimator.h"

// Returns false for a type that the checkout does not have. `calibration`, the caller's, becomes
// what a sweep points at.
bool cf_checkout_measurement(measurement_t *to, const api_measurement_t *from,
                             lighthouseCalibrationSweep_t *calibration);

#endif  // CF_BITCRAZE_MEASUREMENT_CONVERSION_H
