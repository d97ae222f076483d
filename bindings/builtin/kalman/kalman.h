/* The Kalman filter of the builtin provider: the core of the firmware with its parameters, the
 * dispatch of measurements and the variables of the log. */
#ifndef CF_BUILTIN_KALMAN_KALMAN_H
#define CF_BUILTIN_KALMAN_KALMAN_H

#include <stdbool.h>
#include <stdint.h>

#include "api/kalman_core.h"
#include "api/measurement.h"
#include "builtin/kalman/mm_flow.h"
#include "builtin/kalman/supervisor.h"
#include "variables.h"

typedef struct {
  // parameters, kept over a reset of the estimator
  kalmanCoreParams_t params;
  cf_kalman_limits_t limits;
  Axis3f             flow_position;  // [m], of the flow deck in the body frame
  uint8_t            robust_tdoa;    // for models of TDoA and distance, which do not exist yet
  uint8_t            robust_twr;

  // state
  kalmanCoreData_t core;
  cf_flow_log_t    flow;

  // the attitude in degrees belongs to this quaternion (w, x, y, z) and is kept as long as that
  // stays: the filter speaks 1000 times a second and turns at most 200 times
  float      attitude_of[4];
  attitude_t attitude;  // [deg], legacy pitch
} cf_kalman_t;

// Writes the whole struct: default parameters, filter started at now_ms.
void cf_kalman_boot(cf_kalman_t *kalman, uint32_t now_ms);

// Restarts the filter at now_ms from its parameters.
void cf_kalman_init(cf_kalman_t *kalman, uint32_t now_ms);

// Predicts to now_ms. acc [m/s^2] and gyro [rad/s] are averages since the latest prediction.
void cf_kalman_predict(cf_kalman_t *kalman, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                       bool is_flying);

void cf_kalman_add_process_noise(cf_kalman_t *kalman, uint32_t now_ms);

// Fuses a position, pose, range to the floor or optical flow; ignores every other measurement.
// gyro_latest [deg/s] is what the gyroscope measured last.
void cf_kalman_update(cf_kalman_t *kalman, const measurement_t *measurement,
                      const Axis3f *gyro_latest, uint32_t now_ms);

// Returns whether there was anything to do.
bool cf_kalman_finalize(cf_kalman_t *kalman);

// Returns false when the filter should be reset.
bool cf_kalman_is_within_bounds(const cf_kalman_t *kalman);

// Writes the estimate. acc_latest [g] is what the accelerometer measured last.
void cf_kalman_externalize(const cf_kalman_t *kalman, state_t *estimate, const Axis3f *acc_latest);

// Groups kalman and flowdeck; kalman and kalman_pred. Offsets count from cf_kalman_t.
cf_variables_t cf_kalman_parameters(void);
cf_variables_t cf_kalman_logs(void);

#endif  // CF_BUILTIN_KALMAN_KALMAN_H
