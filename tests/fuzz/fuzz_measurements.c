/* Any measurement in the queue of the estimator, with any bits in its numbers. */
#include "fuzz.h"

#include <string.h>

static void enqueue(cf_t *cf, fuzz_input_t *input) {
  measurement_t measurement;
  memset(&measurement, 0, sizeof measurement);
  measurement.type = (MeasurementType)(fuzz_u8(input) % 13);  // one more than there are
  if (measurement.type == MeasurementTypeSweepAngle) {
    // its pointers stay null, as in every queue
    sweepAngleMeasurement_t *sweep = &measurement.data.sweepAngle;
    sweep->sensorId                = fuzz_u8(input);
    sweep->baseStationId           = fuzz_u8(input);
    sweep->sweepId                 = fuzz_u8(input);
    sweep->t                       = fuzz_float(input);
    sweep->measuredSweepAngle      = fuzz_float(input);
    sweep->stdDev                  = fuzz_float(input);
  } else {
    fuzz_bytes(input, &measurement.data, sizeof(tdoaMeasurement_t));
  }
  cf_estimator_enqueue(&cf->onboard.estimator, &measurement);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static cf_t  cf;
  fuzz_input_t input = {data, size};
  fuzz_hovering_drone(&cf, fuzz_u8(&input));
  while (input.left > 0) {
    enqueue(&cf, &input);
    fuzz_run(&cf, fuzz_u8(&input) % 16);
  }
  fuzz_run(&cf, 50);
  return 0;
}
