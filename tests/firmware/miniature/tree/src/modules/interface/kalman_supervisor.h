// Whether the filter has diverged. Has no guard: one prototype does no harm twice.
#include <stdbool.h>

#include "kalman_core.h"

bool kalmanSupervisorIsStateWithinBounds(const kalmanCoreData_t *this);
