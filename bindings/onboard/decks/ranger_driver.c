#include "onboard/decks/ranger_driver.h"

#include "variable_row.h"

#define LONGEST_RANGE 5000u  // [mm]

static const float HALF_CONE = 3.14159265358979f / 180.0f * 7.5f;  // [rad]

void cf_ranger_driver_read(cf_ranger_driver_t *driver, cf_estimator_t *estimator, int direction,
                           uint16_t millimeters, uint32_t tick) {
  driver->ranges[direction] = millimeters;
  if (direction != CF_RANGE_DOWN || millimeters >= LONGEST_RANGE) {
    return;
  }
  const float         distance    = (float)millimeters * 0.001f;
  const measurement_t measurement = {
      .type     = MeasurementTypeTOF,
      .data.tof = {.timestamp     = tick,
                   .distance      = distance,
                   .stdDev        = cf_range_std(distance),
                   .coneHalfAngle = HALF_CONE},
  };
  cf_estimator_enqueue(estimator, &measurement);
}

#define RANGE(name_, direction_) \
  CF_ROW("range", name_, UINT16, CF_CORE, cf_ranger_driver_t, ranges[direction_])

static const cf_variable_t LOGS[] = {
    RANGE("front", CF_RANGE_FRONT), RANGE("back", CF_RANGE_BACK),   RANGE("up", CF_RANGE_UP),
    RANGE("left", CF_RANGE_LEFT),   RANGE("right", CF_RANGE_RIGHT), RANGE("zrange", CF_RANGE_DOWN),
};

cf_variables_t cf_ranger_driver_logs(void) {
  return CF_TABLE(LOGS);
}
