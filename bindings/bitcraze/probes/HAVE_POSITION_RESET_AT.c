// The position loops are reset at a position.
#include "position_controller.h"

void (*const reset)(float, float, float) = positionControllerResetAllPID;
