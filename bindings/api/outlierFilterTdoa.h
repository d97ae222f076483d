/* The firmware's gates for differences of distances, with its names
 * (docs/reference/estimators.md#6).
 *
 * Samples that fit the estimate fill a reservoir of time, others empty it. As long as it is nearly
 * empty everything is let in, so that a lost filter finds back; once it is nearly full only samples
 * that fit are. */
#ifndef OUTLIER_FILTER_TDOA_H
#define OUTLIER_FILTER_TDOA_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"

typedef struct {
  float    integrator;      // [ms], 0 to 300
  uint32_t latestUpdateMs;  // of the latest sample that was possible at all
  bool     isFilterOpen;    // everything is let in
} OutlierFilterTdoaState_t;

// Starts open and empty.
void outlierFilterTdoaReset(OutlierFilterTdoaState_t *this);

// Returns whether to use a sample whose innovation is `error` [m]. A difference that is not smaller
// than the distance between the anchors is refused and leaves no trace.
bool outlierFilterTdoaValidateIntegrator(OutlierFilterTdoaState_t *this,
                                         const tdoaMeasurement_t *tdoa, float error,
                                         uint32_t nowMs);

// The deprecated gate: tolerances in steps, of which the smallest is used that most of the latest
// samples kept to (docs/reference/estimators.md#6.2). No drone asks it; upstream builds it in on
// request, with this state in file scope. All zero is the state after boot, and there is no reset.
#define CF_TDOA_STEPS 5

typedef struct {
  int32_t buckets[CF_TDOA_STEPS];  // 0 to 10, samples beyond each tolerance
  int32_t level;                   // in use: 0 is the smallest tolerance, 5 none at all
  int32_t closeDelay;              // samples before the level may fall
  float   acceptanceLevel;         // [m], tolerance of the latest sample; 100 for none at all
  float   errorDistance;           // [m], of the latest sample
} OutlierFilterTdoaStepsState_t;

// Returns whether to use a sample whose innovation is `error` [m] and whose derivative by the
// position is `jacobian`. estPos is not looked at.
bool outlierFilterTdoaValidateSteps(OutlierFilterTdoaStepsState_t *this,
                                    const tdoaMeasurement_t *tdoa, float error,
                                    const vector_t *jacobian, const point_t *estPos);

#endif  // OUTLIER_FILTER_TDOA_H
