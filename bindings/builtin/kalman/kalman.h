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
  uint8_t            robust_tdoa;    // not 0: the robust model of TDoA
  uint8_t            robust_twr;     // not 0: the robust model of distances

  // an option that the firmware fixes at build time, off by default: fuse the barometer
  bool fuses_barometer;

  // state
  bool             is_flying;  // told with the latest prediction
  kalmanCoreData_t core;
  cf_flow_log_t    flow;

  // what measurement models remember
  OutlierFilterTdoaState_t tdoa_filter;
  OutlierFilterLhState_t   sweep_filter;
  float                    tdoa_innovation;           // [m], by the plain model, used or not
  float                    robust_tdoa_error[9];      // kept over a reset, as in the firmware
  float                    robust_distance_error[9];  // the same

  // the attitude in degrees belongs to this quaternion (w, x, y, z) and is kept as long as that
  // stays: the filter speaks 1000 times a second and turns at most 200 times
  float      attitude_of[4];
  attitude_t attitude;  // [deg], legacy pitch
} cf_kalman_t;

// Writes the whole struct: default parameters, filter started at now_ms.
void cf_kalman_boot(cf_kalman_t *kalman, uint32_t now_ms);

// Restarts the filter and its outlier filters at now_ms, from the parameters.
void cf_kalman_init(cf_kalman_t *kalman, uint32_t now_ms);

// Predicts to now_ms. acc [m/s^2] and gyro [rad/s] are averages since the latest prediction. With a
// noise that is not a number among the parameters the state becomes none.
void cf_kalman_predict(cf_kalman_t *kalman, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                       bool is_flying);

void cf_kalman_add_process_noise(cf_kalman_t *kalman, uint32_t now_ms);

// Fuses a measurement of any type but inertial samples, which belong to the task. The barometer
// only when asked to, and a sweep angle only when all its pointers are there. gyro_latest [deg/s]
// is what the gyroscope measured last.
void cf_kalman_update(cf_kalman_t *kalman, const measurement_t *measurement,
                      const Axis3f *gyro_latest, uint32_t now_ms);

// Returns whether there was anything to do.
bool cf_kalman_finalize(cf_kalman_t *kalman);

// Returns false when the filter should be reset.
bool cf_kalman_is_within_bounds(const cf_kalman_t *kalman);

// Writes the estimate. acc_latest [g] is what the accelerometer measured last.
void cf_kalman_externalize(const cf_kalman_t *kalman, state_t *estimate, const Axis3f *acc_latest);

// Groups kalman and flowdeck; kalman, kalman_pred, outlierf and tdoa. Offsets count from
// cf_kalman_t.
cf_variables_t cf_kalman_parameters(void);
cf_variables_t cf_kalman_logs(void);

#endif  // CF_BUILTIN_KALMAN_KALMAN_H
