// Prediction takes the parameters.
#include "kalman_core.h"

void probe(kalmanCoreData_t *core, kalmanCoreParams_t *params, Axis3f *acc, Axis3f *gyro);
void probe(kalmanCoreData_t *core, kalmanCoreParams_t *params, Axis3f *acc, Axis3f *gyro) {
  kalmanCorePredict(core, params, acc, gyro, 1u, true);
}
