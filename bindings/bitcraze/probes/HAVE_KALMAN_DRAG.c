// The filter knows drag and the center of pressure.
#include "kalman_core.h"

float probe(const kalmanCoreParams_t *params);
float probe(const kalmanCoreParams_t *params) {
  return params->dragB_x + params->dragB_y + params->dragB_z + params->cop_x + params->cop_y +
         params->cop_z;
}
