#pragma once

#include <stdbool.h>

#include "stabilizer_types.h"

// Whether a test is asked for or running: the loop does nothing else then.
bool healthShallWeRunTest(void);
void healthRunTests(sensorData_t *sensors);
