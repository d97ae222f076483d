// The firmware's kalman_core.h for apps.
#include "api/kalman_core.h"
