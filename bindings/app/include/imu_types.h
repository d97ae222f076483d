// The firmware's imu_types.h for apps.
#include "api/imu_types.h"
