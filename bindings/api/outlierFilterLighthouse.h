/* The firmware's gate for sweep angles, with its names (docs/reference/estimators.md#6.3).
 *
 * Good samples close the gate for a while, up to 40 ms ahead; bad ones open it again, at twice the
 * speed. Open lets everything in, closed only what is good. */
#ifndef OUTLIER_FILTER_LIGHTHOUSE_H
#define OUTLIER_FILTER_LIGHTHOUSE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  uint32_t openingTimeMs;    // the gate is closed before
  int32_t  openingWindowMs;  // -16 to 40, from a sample to the next opening
} OutlierFilterLhState_t;

// Starts open.
void outlierFilterLighthouseReset(OutlierFilterLhState_t *this, uint32_t nowMs);

// Returns whether to use a sweep whose innovation is angleError [rad], seen from distanceToBs [m].
// Good means that the two make less than 5 cm.
bool outlierFilterLighthouseValidateSweep(OutlierFilterLhState_t *this, float distanceToBs,
                                          float angleError, uint32_t nowMs);

#endif  // OUTLIER_FILTER_LIGHTHOUSE_H
