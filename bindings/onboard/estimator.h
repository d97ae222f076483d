/* The front end of the state estimators: queue of measurements, choice of the estimator, and the
 * 1 kHz loop around the Kalman filter of a provider (docs/reference/estimators.md#8, #9 and #10.1).
 *
 * In every tick of the stabilizer comes first the estimate (cf_estimator_update). The complementary
 * estimator and the user's own compute it there and then. The Kalman filter has a task of its own,
 * one loop per tick (cf_estimator_run) after the stabilizer's: the controllers see the state of the
 * tick before. The task of an estimator that is not selected stands still, and all measurements go
 * to the other. */
#ifndef CF_ONBOARD_ESTIMATOR_H
#define CF_ONBOARD_ESTIMATOR_H

#include <stdbool.h>
#include <stdint.h>

#include "api/axis3fSubSampler.h"
#include "api/measurement.h"
#include "api/stabilizer_types.h"
#include "onboard/decks/base_stations.h"
#include "provider.h"
#include "variables.h"

// Values of the parameter stabilizer.estimator.
typedef enum {
  StateEstimatorTypeAutoSelect    = 0,  // becomes the complementary one
  StateEstimatorTypeComplementary = 1,
  StateEstimatorTypeKalman        = 2,
  StateEstimatorTypeOutOfTree     = 3,  // a user's own C, where the provider carries one
  StateEstimatorType_COUNT        = 4,
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
  // parameter: set it to restart the Kalman filter in its next loop
  uint8_t resetEstimation;

  uint8_t type;  // StateEstimatorType, the active one

  // the queue: a reader takes all of it, so that the first measurement is always at index 0
  measurement_t queue[CF_ESTIMATOR_QUEUE_SIZE];
  uint32_t      queue_count;
  uint32_t      rejected;  // measurements lost since init

  // complementary estimator
  cf_latest_samples_t latest;

  // Kalman filter: inertial samples
  Axis3fSubSampler_t accSubSampler;   // g to m/s^2
  Axis3fSubSampler_t gyroSubSampler;  // deg/s to rad/s
  Axis3f             accLatest;       // [g]
  Axis3f             gyroLatest;      // [deg/s]

  cf_base_stations_t stations;  // what sweep angles in the queue refer to

  uint32_t nextPredictionMs;
  state_t  estimate;  // of the latest loop

  // rates
  uint32_t rate_start_ms;
  uint32_t events[CF_ESTIMATOR_EVENTS];  // since rate_start_ms
  float    rates[CF_ESTIMATOR_EVENTS];   // [1/s], over the latest complete second
} cf_estimator_t;

// Writes the whole struct and selects an estimator, see cf_estimator_switch_to. The first loop of
// the Kalman filter predicts. The estimate is zero until then.
void cf_estimator_init(cf_estimator_t *estimator, const cf_provider_t *provider,
                       void *provider_state, int type, uint32_t now_ms);

// Selects an estimator. AutoSelect becomes the default, the complementary one; the Kalman filter
// restarts from kalman.initialX and so on, the complementary estimator goes on from where it was.
// A number that does not exist with this provider changes nothing and returns false.
bool cf_estimator_switch_to(cf_estimator_t *estimator, const cf_provider_t *provider,
                            void *provider_state, int type, uint32_t now_ms);

// Whether there is an estimator of this number. AutoSelect counts.
bool cf_estimator_exists(const cf_provider_t *provider, int type);

// Returns the name of an estimator, "None" for AutoSelect, null for a number that does not exist.
const char *cf_estimator_name(int type);

// Puts a measurement at the end of the queue. When that is full, the measurement is lost: returns
// false and counts it.
bool cf_estimator_enqueue(cf_estimator_t *estimator, const measurement_t *measurement);

// The estimate for this step of the stabilizer. The Kalman filter's is a copy; the others take what
// is in the queue. The complementary estimator leaves horizontal velocity and acceleration as they
// are in `estimate`, and the user's own whatever it does not write.
void cf_estimator_update(cf_estimator_t *estimator, const cf_provider_t *provider,
                         void *provider_state, state_t *estimate, stabilizerStep_t step,
                         uint32_t now_ms);

// Takes everything out of the queue, and returns how many that were. Sweep angles, which refer to
// base stations by their number there, come with pointers into `sweeps`. Both arrays have
// CF_ESTIMATOR_QUEUE_SIZE entries.
int cf_estimator_take_queue(cf_estimator_t *estimator, measurement_t *queue,
                            cf_resolved_sweep_t *sweeps);

// Copies the estimate of the Kalman filter's latest loop.
void cf_estimator_get(const cf_estimator_t *estimator, state_t *estimate);

// One loop of the Kalman filter's task, if it is selected; to be called once per millisecond.
// is_flying is the supervisor's opinion.
void cf_estimator_run(cf_estimator_t *estimator, const cf_provider_t *provider,
                      void *provider_state, uint32_t now_ms, bool is_flying);

// kalman.resetEstimation; the rates of groups kalman and estimator. Offsets count from
// cf_estimator_t.
cf_variables_t cf_estimator_parameters(void);
cf_variables_t cf_estimator_logs(void);

#endif  // CF_ONBOARD_ESTIMATOR_H
