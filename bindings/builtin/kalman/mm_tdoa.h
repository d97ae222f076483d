/* Difference of distances, with what the log shows of it (docs/reference/estimators.md#5.9). */
#ifndef CF_BUILTIN_KALMAN_MM_TDOA_H
#define CF_BUILTIN_KALMAN_MM_TDOA_H

#include <stdint.h>

#include "api/kalman_core.h"

// kalmanCoreUpdateWithTdoa that returns the innovation [m], whether it was used or not.
float cf_mm_tdoa_update(kalmanCoreData_t *core, const tdoaMeasurement_t *tdoa, uint32_t now_ms,
                        OutlierFilterTdoaState_t *filter);

#endif  // CF_BUILTIN_KALMAN_MM_TDOA_H
