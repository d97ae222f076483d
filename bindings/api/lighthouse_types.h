/* Types of the lighthouse positioning system, with the firmware's names
 * (docs/reference/control-pid.md#2). */
#ifndef LIGHTHOUSE_TYPES_H
#define LIGHTHOUSE_TYPES_H

#include <stdbool.h>
#include <stdint.h>

typedef float vec3d[3];
typedef float mat3d[3][3];

// How one light plane of a base station deviates from the ideal one.
typedef struct {
  float phase;      // [rad]
  float tilt;       // [rad]
  float curve;      // [rad]
  float gibmag;     // [rad]
  float gibphase;   // [rad]
  float ogeemag;    // [rad], second generation only
  float ogeephase;  // [rad], second generation only
} lighthouseCalibrationSweep_t;

// Both light planes of one base station. Upstream packs this struct; here it is aligned.
typedef struct {
  lighthouseCalibrationSweep_t sweep[2];
  uint32_t                     uid;
  bool                         valid;
} lighthouseCalibration_t;

// Predicts the sweep angle [rad] of a point x, y, z [m] in the frame of the rotor, for a light
// plane tilted by t [rad].
typedef float (*lighthouseCalibrationMeasurementModel_t)(const float x, const float y,
                                                         const float z, const float t,
                                                         const lighthouseCalibrationSweep_t *calib);

#endif  // LIGHTHOUSE_TYPES_H
