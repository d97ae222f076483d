#pragma once

#include "kalman_core.h"

void kalmanCoreUpdateWithDistance(kalmanCoreData_t *this, distanceMeasurement_t *d);
