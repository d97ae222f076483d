// Prediction takes the parameters.
#include "kalman_core.h"

void (*const predict)(kalmanCoreData_t *, const kalmanCoreParams_t *, Axis3f *, Axis3f *,
                      const uint32_t, bool) = kalmanCorePredict;
