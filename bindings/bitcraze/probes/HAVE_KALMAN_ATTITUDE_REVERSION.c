// The drift back to the first attitude is a parameter.
#include "kalman_core.h"

float reversion_of(const kalmanCoreParams_t *params);
float reversion_of(const kalmanCoreParams_t *params) {
  return params->attitudeReversion;
}
