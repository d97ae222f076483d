/* The estimator task: queue of measurements, averages of the inertial samples, and the 1 kHz loop
 * around the Kalman filter of a provider (estimators dossier 8 and 9).
 *
 * In every tick of the stabilizer comes first the estimate (cf_estimator_get), then one loop of the
 * task (cf_estimator_run): the controllers see the state of the tick before. */
#ifndef CF_ONBOARD_ESTIMATOR_H
#define CF_ONBOARD_ESTIMATOR_H

#include <stdbool.h>
#include <stdint.h>

#include "api/axis3fSubSampler.h"
#include "api/measurement.h"
#include "api/stabilizer_types.h"
#include "provider.h"
#include "variables.h"

// Values of the parameter stabilizer.estimator. The complementary estimator does not exist yet.
typedef enum {
  StateEstimatorTypeAutoSelect    = 0,
  StateEstimatorTypeComplementary = 1,
  StateEstimatorTypeKalman        = 2,
  StateEstimatorType_COUNT        = 3,
} StateEstimatorType;

#define CF_ESTIMATOR_QUEUE_SIZE 20

// Events counted by the task, averaged over a second.
typedef enum {
  CF_ESTIMATOR_UPDATED   = 0,  // loops
  CF_ESTIMATOR_PREDICTED = 1,
  CF_ESTIMATOR_FINALIZED = 2,  // only those that had something to do
  CF_ESTIMATOR_APPENDED  = 3,  // measurements offered to the queue
  CF_ESTIMATOR_REJECTED  = 4,  // of those, lost because it was full
  CF_ESTIMATOR_EVENTS    = 5,
} cf_estimator_event_t;

typedef struct {
  // parameter: set it to restart the filter in the next loop
  uint8_t resetEstimation;

  // the queue, a ring
  measurement_t queue[CF_ESTIMATOR_QUEUE_SIZE];
  uint32_t      queue_first;
  uint32_t      queue_count;
  uint32_t      rejected;  // measurements lost since init

  // inertial samples
  Axis3fSubSampler_t accSubSampler;   // g to m/s^2
  Axis3fSubSampler_t gyroSubSampler;  // deg/s to rad/s
  Axis3f             accLatest;       // [g]
  Axis3f             gyroLatest;      // [deg/s]

  uint32_t nextPredictionMs;
  state_t  estimate;  // of the latest loop

  // rates
  uint32_t rate_start_ms;
  uint32_t events[CF_ESTIMATOR_EVENTS];  // since rate_start_ms
  float    rates[CF_ESTIMATOR_EVENTS];   // [1/s], over the latest complete second
} cf_estimator_t;

// Writes the whole struct, (re)starts the filter of the provider and makes the first loop predict.
// The estimate is zero until then.
void cf_estimator_init(cf_estimator_t *estimator, const cf_provider_t *provider,
                       void *provider_state, uint32_t now_ms);

// Puts a measurement at the end of the queue. When that is full, the measurement is lost: returns
// false and counts it.
bool cf_estimator_enqueue(cf_estimator_t *estimator, const measurement_t *measurement);

// Copies the estimate of the latest loop.
void cf_estimator_get(const cf_estimator_t *estimator, state_t *estimate);

// One loop of the task, to be called once per millisecond. is_flying is the supervisor's opinion.
void cf_estimator_run(cf_estimator_t *estimator, const cf_provider_t *provider,
                      void *provider_state, uint32_t now_ms, bool is_flying);

// kalman.resetEstimation; the rates of groups kalman and estimator. Offsets count from
// cf_estimator_t.
cf_variables_t cf_estimator_parameters(void);
cf_variables_t cf_estimator_logs(void);

#endif  // CF_ONBOARD_ESTIMATOR_H
