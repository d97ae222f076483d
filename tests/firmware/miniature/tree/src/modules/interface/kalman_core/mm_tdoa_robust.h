#pragma once

#include "kalman_core.h"
#include "outlierFilterTdoa.h"

void kalmanCoreRobustUpdateWithTdoa(kalmanCoreData_t *this, tdoaMeasurement_t *tdoa,
                                    OutlierFilterTdoaState_t *outlierFilterState);
