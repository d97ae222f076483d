#pragma once

#include "kalman_core.h"

void kalmanCoreRobustUpdateWithDistance(kalmanCoreData_t *this, distanceMeasurement_t *d);
