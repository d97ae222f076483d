#ifndef STABILIZER_H_
#define STABILIZER_H_

#include <stdbool.h>
#include <stdint.h>

#include "estimator.h"

void stabilizerInit(StateEstimatorType estimator);
bool stabilizerTest(void);

#endif  // STABILIZER_H_
