#pragma once

#include "kalman_core.h"
#include "outlierFilterLighthouse.h"

void kalmanCoreUpdateWithSweepAngles(kalmanCoreData_t *this, sweepAngleMeasurement_t *sweepInfo,
                                     const uint32_t          nowMs,
                                     OutlierFilterLhState_t *sweepOutlierFilterState);
