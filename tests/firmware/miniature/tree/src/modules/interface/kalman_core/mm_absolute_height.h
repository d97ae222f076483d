#pragma once

#include "kalman_core.h"

void kalmanCoreUpdateWithAbsoluteHeight(kalmanCoreData_t *this, heightMeasurement_t *height);
