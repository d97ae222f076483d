// The drift back to the first attitude is a parameter.
#include "kalman_core.h"

float probe(const kalmanCoreParams_t *params);
float probe(const kalmanCoreParams_t *params) {
  return params->attitudeReversion;
}
