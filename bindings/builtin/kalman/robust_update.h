/* Updates that trust an odd measurement less, and the state more
 * (docs/reference/estimators.md#5.10): weights of Geman and McClure, found in two rounds. Internal
 * to C. */
#ifndef CF_BUILTIN_KALMAN_ROBUST_UPDATE_H
#define CF_BUILTIN_KALMAN_ROBUST_UPDATE_H

#include "api/kalman_core.h"
#include "builtin/kalman/anchors.h"

typedef struct {
  float measurement_sigma;  // of the weight of a measurement
  float state_sigma;        // of the weight of a state
  cf_linearization_t (*linearize)(const float X[KC_STATE_DIM], const void *measurement);
} cf_robust_model_t;

// Fuses a measurement of std_dev [m]. Does nothing where the model has no derivative. x_err is what
// the latest update with this model corrected, all zero before the first; it weights the states of
// the first round and is replaced.
void cf_robust_update(kalmanCoreData_t *core, const cf_robust_model_t *model,
                      const void *measurement, float std_dev, float x_err[KC_STATE_DIM]);

#endif  // CF_BUILTIN_KALMAN_ROBUST_UPDATE_H
