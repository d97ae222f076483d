/* Optical flow with the place of the sensor, and with what the log shows of it
 * (docs/reference/estimators.md#5.7). */
#ifndef CF_BUILTIN_KALMAN_MM_FLOW_H
#define CF_BUILTIN_KALMAN_MM_FLOW_H

#include "api/kalman_core.h"

typedef struct {
  float predicted_x;  // [motion pixels]
  float predicted_y;
  float measured_x;
  float measured_y;
} cf_flow_log_t;

// kalmanCoreUpdateWithFlow for a sensor at `lever_arm` [m] in the body frame. Fills the log.
void cf_mm_flow_update(kalmanCoreData_t *core, const flowMeasurement_t *flow, const Axis3f *gyro,
                       const Axis3f *lever_arm, cf_flow_log_t *log);

#endif  // CF_BUILTIN_KALMAN_MM_FLOW_H
