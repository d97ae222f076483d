// Samples are asked for with the tick.
#include "sensors.h"

void (*const probe)(sensorData_t *, const uint32_t) = sensorsAcquire;
