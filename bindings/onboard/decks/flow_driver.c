#include "onboard/decks/flow_driver.h"

#include <stdlib.h>

#include "variable_row.h"

#define FIXED_STD 2.0f  // [counts]
#define MIN_STD 0.1f    // [counts]
#define OUTLIER 100     // [counts]

static const float TICK = 0.001f;  // [s]

void cf_flow_driver_init(cf_flow_driver_t *driver, uint32_t now_ms) {
  *driver = (cf_flow_driver_t){.fixed_std = FIXED_STD, .last_tick = now_ms};
}

static float std_of(const cf_flow_driver_t *driver) {
  if (!driver->adaptive) {
    return driver->fixed_std;
  }
  const float std = 0.0007984f * (float)driver->reading.shutter + 0.4335f;
  return std > MIN_STD ? std : MIN_STD;
}

static void read_flow(cf_flow_driver_t *driver, cf_estimator_t *estimator, uint32_t tick) {
  // the chip lies turned on the board
  const int x = -driver->reading.delta_y;
  const int y = -driver->reading.delta_x;
  if (abs(x) >= OUTLIER || abs(y) >= OUTLIER) {
    driver->outliers++;  // the next reading spans its time too
    return;
  }

  const float age   = (float)(tick - driver->last_tick) * TICK;
  driver->last_tick = tick;
  driver->std       = std_of(driver);
  if (driver->disable || driver->reading.motion != CF_FLOW_MOTION) {
    return;
  }
  const measurement_t measurement = {
      .type      = MeasurementTypeFlow,
      .data.flow = {.timestamp = tick,
                    .dpixel    = {(float)x, (float)y},
                    .stdDevX   = driver->std,
                    .stdDevY   = driver->std,
                    .dt        = age},
  };
  cf_estimator_enqueue(estimator, &measurement);
}

void cf_flow_driver_read(cf_flow_driver_t *driver, cf_estimator_t *estimator,
                         const cf_flow_reading_t *reading, uint32_t tick) {
  driver->reading = *reading;
  read_flow(driver, estimator, tick);
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("motion", "disable", UINT8, 0, cf_flow_driver_t, disable),
    CF_ROW("motion", "adaptive", UINT8, 0, cf_flow_driver_t, adaptive),
    CF_ROW("motion", "flowStdFixed", FLOAT, CF_CORE, cf_flow_driver_t, fixed_std),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("motion", "motion", UINT8, 0, cf_flow_driver_t, reading.motion),
    CF_ROW("motion", "deltaX", INT16, 0, cf_flow_driver_t, reading.delta_x),
    CF_ROW("motion", "deltaY", INT16, 0, cf_flow_driver_t, reading.delta_y),
    CF_ROW("motion", "shutter", UINT16, 0, cf_flow_driver_t, reading.shutter),
    CF_ROW("motion", "maxRaw", UINT8, 0, cf_flow_driver_t, unused[0]),
    CF_ROW("motion", "minRaw", UINT8, 0, cf_flow_driver_t, unused[1]),
    CF_ROW("motion", "Rawsum", UINT8, 0, cf_flow_driver_t, unused[2]),
    CF_ROW("motion", "outlierCount", UINT8, 0, cf_flow_driver_t, outliers),
    CF_ROW("motion", "squal", UINT8, 0, cf_flow_driver_t, reading.squal),
    CF_ROW("motion", "std", FLOAT, 0, cf_flow_driver_t, std),
};

cf_variables_t cf_flow_driver_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_flow_driver_logs(void) {
  return CF_TABLE(LOGS);
}
