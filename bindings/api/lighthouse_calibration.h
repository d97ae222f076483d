/* What a base station of the second generation sees of a point, with the firmware's name.
 *
 * Calibration enters by phase, tilt and gibbous terms, as docs/reference/estimators.md#5.11 has it;
 * its curve and ogee terms are not described there and are left out. The first generation would
 * need them, too. All zero describes ideal light planes. */
#ifndef LIGHTHOUSE_CALIBRATION_H
#define LIGHTHOUSE_CALIBRATION_H

#include "api/lighthouse_types.h"

// Returns the sweep angle [rad] at which the light plane, tilted by t [rad], passes the point x, y,
// z [m] in the frame of the rotor. NaN on the axis of the rotor, x = y = 0, at its height.
float lighthouseCalibrationMeasurementModelLh2(const float x, const float y, const float z,
                                               const float                         t,
                                               const lighthouseCalibrationSweep_t *calib);

#endif  // LIGHTHOUSE_CALIBRATION_H
