/* The scalar update for measurements of one state alone. Internal to C. */
#ifndef CF_BUILTIN_KALMAN_SCALAR_UPDATE_H
#define CF_BUILTIN_KALMAN_SCALAR_UPDATE_H

#include "api/kalman_core.h"

// kalmanCoreScalarUpdate with an Hm whose only entry is H, at the state h. H is not zero.
void cf_scalar_update_single(kalmanCoreData_t *core, int h, float H, float error, float std_dev);

#endif  // CF_BUILTIN_KALMAN_SCALAR_UPDATE_H
