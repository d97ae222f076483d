/* Distances to radio anchors, linearized at a state: what plain and robust models share
 * (docs/reference/estimators.md#5.4 and #5.9). Internal to C. */
#ifndef CF_BUILTIN_KALMAN_ANCHORS_H
#define CF_BUILTIN_KALMAN_ANCHORS_H

#include <stdbool.h>

#include "api/kalman_core.h"

typedef struct {
  float error;            // [m], measured minus predicted
  bool  has_derivative;   // if not, H is zero
  float H[KC_STATE_DIM];  // of the prediction, by the state
} cf_linearization_t;

// At the anchor itself the derivative is taken as that along x.
cf_linearization_t cf_linearize_distance(const float                  X[KC_STATE_DIM],
                                         const distanceMeasurement_t *distance);

// At one of the anchors there is no derivative.
cf_linearization_t cf_linearize_tdoa(const float X[KC_STATE_DIM], const tdoaMeasurement_t *tdoa);

#endif  // CF_BUILTIN_KALMAN_ANCHORS_H
