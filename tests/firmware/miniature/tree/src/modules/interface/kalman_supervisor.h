#pragma once

#include "kalman_core.h"

bool kalmanSupervisorIsStateWithinBounds(const kalmanCoreData_t *this);
