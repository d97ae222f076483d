/* A user's own controller and estimator, compiled against the checkout's headers. */
#include "bitcraze/adapter.h"

#include "library/out_of_tree.h"

#include "bitcraze/conversions.h"
#include "library/work.h"

#if __has_include("estimator.h")
#include "estimator.h"
#else
#include "estimator/estimator.h"
#endif

#define MAYBE __attribute__((weak))  // null where the library was linked without

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) MAYBE;
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep) MAYBE;
bool estimatorDequeue(measurement_t *measurement);

void cf_out_of_tree_control(control_t *control, const setpoint_t *setpoint,
                            const sensorData_t *sensors, const state_t *state,
                            stabilizerStep_t step) {
  cf_work_on("controllerOutOfTree");
  controllerOutOfTree(control, setpoint, sensors, state, step);
}

void cf_out_of_tree_select_estimator(void *state CF_UNUSED) {
  cf_out_of_tree_init_estimator();
}

void cf_out_of_tree_estimate(void *state CF_UNUSED, const api_measurement_t *queue, int count,
                             api_state_t *estimate, api_stabilizerStep_t step,
                             uint32_t now_ms CF_UNUSED) {
  state_t is = cf_checkout_state(estimate);
  cf_out_of_tree_open_queue(queue, count, sizeof *queue);
  cf_work_on("estimatorOutOfTree");
  estimatorOutOfTree(&is, step);
  cf_out_of_tree_close_queue();
  cf_api_state(estimate, &is);
}

// ------------------------------------------------------------------------------------------ queue

// what a sweep of the queue points at, until the next one is taken
static lighthouseCalibrationSweep_t calibration CF_LIBRARY_KEEP = {0};

// Returns false for a type that the checkout does not have.
static bool convert(measurement_t *to, const api_measurement_t *from) {
  switch (from->type) {
    case api_MeasurementTypeTDOA:
      to->type      = MeasurementTypeTDOA;
      to->data.tdoa = cf_checkout_tdoa(&from->data.tdoa);
      return true;
    case api_MeasurementTypePosition:
      to->type          = MeasurementTypePosition;
      to->data.position = cf_checkout_position(&from->data.position);
      return true;
    case api_MeasurementTypePose:
      to->type      = MeasurementTypePose;
      to->data.pose = cf_checkout_pose(&from->data.pose);
      return true;
    case api_MeasurementTypeDistance:
      to->type          = MeasurementTypeDistance;
      to->data.distance = cf_checkout_distance(&from->data.distance);
      return true;
    case api_MeasurementTypeTOF:
      to->type     = MeasurementTypeTOF;
      to->data.tof = cf_checkout_tof(&from->data.tof);
      return true;
    case api_MeasurementTypeAbsoluteHeight:
      to->type        = MeasurementTypeAbsoluteHeight;
      to->data.height = cf_checkout_height(&from->data.height);
      return true;
    case api_MeasurementTypeFlow:
      to->type      = MeasurementTypeFlow;
      to->data.flow = cf_checkout_flow(&from->data.flow);
      return true;
    case api_MeasurementTypeYawError:
      to->type          = MeasurementTypeYawError;
      to->data.yawError = cf_checkout_yaw_error(&from->data.yawError);
      return true;
    case api_MeasurementTypeSweepAngle:
      to->type            = MeasurementTypeSweepAngle;
      to->data.sweepAngle = cf_checkout_sweep(&from->data.sweepAngle, &calibration);
      return true;
    case api_MeasurementTypeGyroscope:
      to->type                = MeasurementTypeGyroscope;
      to->data.gyroscope.gyro = cf_checkout_axes(&from->data.gyroscope.gyro);
      return true;
    case api_MeasurementTypeAcceleration:
      to->type                  = MeasurementTypeAcceleration;
      to->data.acceleration.acc = cf_checkout_axes(&from->data.acceleration.acc);
      return true;
    case api_MeasurementTypeBarometer:
      to->type                = MeasurementTypeBarometer;
      to->data.barometer.baro = cf_checkout_baro(&from->data.barometer.baro);
      return true;
    default:
      return false;
  }
}

bool estimatorDequeue(measurement_t *measurement) {
  for (const void *next; (next = cf_out_of_tree_next()) != NULL;) {
    if (convert(measurement, next)) {
      return true;
    }
  }
  return false;
}
