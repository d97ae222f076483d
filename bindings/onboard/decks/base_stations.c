#include "onboard/decks/base_stations.h"

#include <math.h>
#include <string.h>

#include "api/lighthouse_calibration.h"

#define TAN_30_DEG 0.577350269f
#define CORRECTIONS 4

static void fill(cf_resolved_sweep_t *resolved, const cf_station_data_t *station) {
  sweepAngleMeasurement_t *sweep = &resolved->measurement.data.sweepAngle;
  for (int i = 0; i < 3; i++) {
    for (int k = 0; k < 3; k++) {
      resolved->rotation_inverse[i][k] = station->rotation[k][i];
    }
  }
  sweep->sensorPos                   = cf_lighthouse_sensor_position(sweep->sensorId);
  sweep->rotorPos                    = &station->origin;
  sweep->rotorRot                    = &station->rotation;
  sweep->rotorRotInv                 = &resolved->rotation_inverse;
  sweep->calib                       = &station->calibration.sweep[sweep->sweepId];
  sweep->calibrationMeasurementModel = lighthouseCalibrationMeasurementModelLh2;
}

const measurement_t *cf_lighthouse_resolve(cf_resolved_sweep_t      *resolved,
                                           const measurement_t      *measurement,
                                           const cf_base_stations_t *stations) {
  if (measurement->type != MeasurementTypeSweepAngle) {
    return measurement;
  }
  resolved->measurement                = *measurement;
  const sweepAngleMeasurement_t *sweep = &measurement->data.sweepAngle;
  if (sweep->baseStationId < CF_LIGHTHOUSE_STATIONS && sweep->sweepId < CF_LIGHTHOUSE_SWEEPS &&
      sweep->sensorId < CF_LIGHTHOUSE_SENSORS) {
    fill(resolved, &stations->list[sweep->baseStationId]);
  }
  return &resolved->measurement;
}

// Two ideal planes at -30 and +30 deg: angles azimuth -+ asin(slope tan 30 deg).
static void ideal_ray(const float angles[CF_LIGHTHOUSE_SWEEPS], float ray[3]) {
  const float azimuth = 0.5f * (angles[0] + angles[1]);
  ray[0]              = cosf(azimuth);
  ray[1]              = sinf(azimuth);
  ray[2]              = sinf(0.5f * (angles[1] - angles[0])) / TAN_30_DEG;
}

static bool is_ideal(const lighthouseCalibrationSweep_t *sweep) {
  return sweep->phase == 0.0f && sweep->tilt == 0.0f && sweep->gibmag == 0.0f;
}

// Removes calibration from measured angles by fixed-point iteration: what the model adds to the ray
// that the present guess describes is taken away.
static void correct(const lighthouseCalibrationSweep_t planes[CF_LIGHTHOUSE_SWEEPS],
                    const float                        measured[CF_LIGHTHOUSE_SWEEPS],
                    float                              corrected[CF_LIGHTHOUSE_SWEEPS]) {
  memcpy(corrected, measured, CF_LIGHTHOUSE_SWEEPS * sizeof *corrected);
  if (is_ideal(&planes[0]) && is_ideal(&planes[1])) {
    return;
  }
  for (int n = 0; n < CORRECTIONS; n++) {
    float ray[3];
    ideal_ray(corrected, ray);
    for (int i = 0; i < CF_LIGHTHOUSE_SWEEPS; i++) {
      const float predicted = lighthouseCalibrationMeasurementModelLh2(
          ray[0], ray[1], ray[2], cf_lighthouse_tilt(i), &planes[i]);
      corrected[i] += measured[i] - predicted;
    }
  }
}

void cf_lighthouse_ray(const cf_station_data_t *station, const float angles[CF_LIGHTHOUSE_SWEEPS],
                       float direction[3]) {
  float corrected[CF_LIGHTHOUSE_SWEEPS];
  float ray[3];
  correct(station->calibration.sweep, angles, corrected);
  ideal_ray(corrected, ray);
  for (int i = 0; i < 3; i++) {
    direction[i] = station->rotation[i][0] * ray[0] + station->rotation[i][1] * ray[1] +
                   station->rotation[i][2] * ray[2];
  }
}
