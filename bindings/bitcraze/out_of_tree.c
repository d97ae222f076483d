/* A user's own controller and estimator, compiled against the checkout's headers. */
#include "bitcraze/adapter.h"

#include "library/out_of_tree.h"

#include "bitcraze/conversions.h"
#include "bitcraze/measurement_conversion.h"
#include "library/work.h"

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

#if !CF_SYSTEM  // else the queue is theirs
// what a sweep of the queue points at, until the next one is taken
static lighthouseCalibrationSweep_t calibration CF_LIBRARY_KEEP = {0};

bool estimatorDequeue(measurement_t *measurement) {
  for (const void *next; (next = cf_out_of_tree_next()) != NULL;) {
    if (cf_checkout_measurement(measurement, next, &calibration)) {
      return true;
    }
  }
  return false;
}
#endif
