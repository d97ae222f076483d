/* What both gates for differences of distances ask first. Internal to C. */
#ifndef CF_BUILTIN_KALMAN_OUTLIER_FILTER_TDOA_H
#define CF_BUILTIN_KALMAN_OUTLIER_FILTER_TDOA_H

#include "api/outlierFilterTdoa.h"

// In a triangle no side is longer than the other two together: returns whether the difference is
// smaller than the distance between the anchors.
bool cf_tdoa_is_possible(const tdoaMeasurement_t *tdoa);

#endif  // CF_BUILTIN_KALMAN_OUTLIER_FILTER_TDOA_H
