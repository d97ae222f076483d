#pragma once

#include "kalman_core.h"

void kalmanCoreUpdateWithTof(kalmanCoreData_t *this, tofMeasurement_t *tof);
