#pragma once

#include "kalman_core.h"

void kalmanCoreUpdateWithPosition(kalmanCoreData_t *this, positionMeasurement_t *xyz);
