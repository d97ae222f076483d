#pragma once

#include "kalman_core.h"

void kalmanCoreUpdateWithFlow(kalmanCoreData_t *this, const flowMeasurement_t *flow,
                              const Axis3f *gyro);
