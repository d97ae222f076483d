// The deprecated gate for differences of distances, on request of the configuration.
#pragma once

#include "stabilizer_types.h"

bool outlierFilterTdoaValidateSteps(const tdoaMeasurement_t *tdoa, const float error,
                                    const vector_t *jacobian, const point_t *estPos);
