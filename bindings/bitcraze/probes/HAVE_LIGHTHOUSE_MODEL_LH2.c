// The model of a base station of the second generation.
// clang-format off: headers use what comes before
#include "stabilizer_types.h"
#include "lighthouse_calibration.h"
// clang-format on

const lighthouseCalibrationMeasurementModel_t probe = lighthouseCalibrationMeasurementModelLh2;
