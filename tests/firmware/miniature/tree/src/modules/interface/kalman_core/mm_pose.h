#pragma once

#include "kalman_core.h"

void kalmanCoreUpdateWithPose(kalmanCoreData_t *this, poseMeasurement_t *pose);
