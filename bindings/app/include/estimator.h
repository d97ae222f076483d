/* The firmware's estimator.h for apps: the functions that an app brings to fly as estimator
 * "OutOfTree", and the queue that it reads (docs/reference/estimators.md#9 and #11). */
#ifndef CF_APP_ESTIMATOR_H
#define CF_APP_ESTIMATOR_H

#include <stdbool.h>

#include "api/measurement.h"
#include "stabilizer_types.h"

// The app's: called when the estimator is selected; a false test stops the drone.
void estimatorOutOfTreeInit(void);
bool estimatorOutOfTreeTest(void);

// The app's: called at 1 kHz while the estimator is selected. `state` is that of the call before.
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep);

// Takes the next measurement that came since the latest call, oldest first. Returns false when
// there is none.
bool estimatorDequeue(measurement_t *measurement);

#endif  // CF_APP_ESTIMATOR_H
