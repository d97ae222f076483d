/* What sweep angles point at. On the vehicle that stays where it is; here it comes with every
 * measurement, and is kept beside the queue of the estimator for as long as the measurement waits
 * there: many ticks, while the loop does not run. */
#include "bitcraze/system/system.h"

#include <string.h>

// clang-format off: the operating system first
#include "FreeRTOS.h"
#include "estimator.h"
// clang-format on

#include "bitcraze/measurement_conversion.h"
#include "bitcraze/rtos/kernel.h"

// Its pointers show into the same place, where the image map follows them.
typedef struct {
  sweepAngleMeasurement_t      measurement;
  vec3d                        sensor_position;
  vec3d                        rotor_position;
  mat3d                        rotor_rotation;
  mat3d                        rotor_rotation_inverse;
  lighthouseCalibrationSweep_t calibration;
} sweep_t;

// A ring of the queued sweeps, the oldest one first.
static sweep_t sweeps[CF_SYSTEM_MEASUREMENTS];
static int     first;
static int     waiting;

static sweep_t *sweep_at(int place) {
  return &sweeps[(first + place) % CF_SYSTEM_MEASUREMENTS];
}

#define KEEP(pointer_, place_)                                   \
  if ((pointer_) != NULL) {                                      \
    memcpy(&(place_), (const void *)(pointer_), sizeof(place_)); \
    (pointer_) = (const void *)&(place_);                        \
  }

static void keep(sweepAngleMeasurement_t *measurement) {
  sweep_t *sweep = sweep_at(waiting++);
  KEEP(measurement->sensorPos, sweep->sensor_position)
  KEEP(measurement->rotorPos, sweep->rotor_position)
  KEEP(measurement->rotorRot, sweep->rotor_rotation)
  KEEP(measurement->rotorRotInv, sweep->rotor_rotation_inverse)
  KEEP(measurement->calib, sweep->calibration)
  sweep->measurement = *measurement;
}

void cf_system_enqueue(const api_measurement_t *from) {
  measurement_t                measurement;
  lighthouseCalibrationSweep_t calibration;
  memset(&measurement, 0, sizeof measurement);
  if (!cf_checkout_measurement(&measurement, from, &calibration)) {
    return;
  }
  const bool is_sweep = measurement.type == MeasurementTypeSweepAngle;
  if (is_sweep) {
    if (waiting == CF_SYSTEM_MEASUREMENTS) {
      return;
    }
    keep(&measurement.data.sweepAngle);
  }
  const uint32_t refused = cf_rtos_refused;
  estimatorEnqueue(&measurement);
  if (is_sweep && cf_rtos_refused != refused) {
    waiting--;
  }
}

static bool is_same(const sweepAngleMeasurement_t *one, const sweepAngleMeasurement_t *other) {
  return one->timestamp == other->timestamp && one->sensorId == other->sensorId &&
         one->baseStationId == other->baseStationId && one->sweepId == other->sweepId &&
         one->measuredSweepAngle == other->measuredSweepAngle;
}

// The linker redirects all calls of estimatorDequeue() here (-Wl,--wrap). The memory of a drone may
// have moved since the measurement was queued, and pointers inside a queue are not relocated.
bool __real_estimatorDequeue(measurement_t *measurement);
bool __wrap_estimatorDequeue(measurement_t *measurement);

bool __wrap_estimatorDequeue(measurement_t *measurement) {
  if (!__real_estimatorDequeue(measurement)) {
    return false;
  }
  if (measurement->type == MeasurementTypeSweepAngle) {
    for (int i = 0; i < waiting; i++) {
      const sweep_t *sweep = sweep_at(i);
      if (is_same(&sweep->measurement, &measurement->data.sweepAngle)) {
        measurement->data.sweepAngle = sweep->measurement;
        first                        = (first + i + 1) % CF_SYSTEM_MEASUREMENTS;
        waiting -= i + 1;
        break;
      }
    }
  }
  return true;
}
