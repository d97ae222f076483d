/* Driver of everything that measures distances: keeps the latest for the log, and hands those that
 * look down to the estimator.
 *
 * docs/reference/estimators.md#13.1. */
#ifndef CF_ONBOARD_DECKS_RANGER_DRIVER_H
#define CF_ONBOARD_DECKS_RANGER_DRIVER_H

#include <stdint.h>

#include "deck_facts.h"
#include "onboard/estimator.h"
#include "variables.h"

typedef struct {
  uint16_t ranges[CF_RANGE_COUNT];  // [mm]; 0 where no chip has measured yet
} cf_ranger_driver_t;

// Takes a reading [mm] at a tick [ms]. A range down to the floor below 5 m is enqueued.
void cf_ranger_driver_read(cf_ranger_driver_t *driver, cf_estimator_t *estimator, int direction,
                           uint16_t millimeters, uint32_t tick);

// Group range. Offsets count from cf_ranger_driver_t.
cf_variables_t cf_ranger_driver_logs(void);

#endif  // CF_ONBOARD_DECKS_RANGER_DRIVER_H
