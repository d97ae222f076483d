/* Driver of the flow deck: registers in, flow for the estimator out.
 *
 * docs/reference/estimators.md#13.2. Its range finder is read by ranger_driver.h. */
#ifndef CF_ONBOARD_DECKS_FLOW_DRIVER_H
#define CF_ONBOARD_DECKS_FLOW_DRIVER_H

#include <stdint.h>

#include "deck_facts.h"
#include "onboard/estimator.h"
#include "variables.h"

typedef struct {
  // parameters
  uint8_t disable;    // not 0: flow does not reach the estimator
  uint8_t adaptive;   // not 0: the standard deviation follows the shutter
  float   fixed_std;  // [counts], otherwise

  // log
  cf_flow_reading_t reading;    // the latest registers
  float             std;        // [counts], told with the latest flow
  uint8_t           outliers;   // readings of 100 counts and more; wraps around
  uint8_t           unused[3];  // brightness registers that are not simulated: 0

  uint32_t last_tick;  // [ms], of the latest reading that was no outlier
} cf_flow_driver_t;

// Writes the whole struct at a tick [ms], one before the first that is sensed.
void cf_flow_driver_init(cf_flow_driver_t *driver, uint32_t now_ms);

// Takes the registers at a tick [ms] and enqueues the flow that moved and was no outlier.
void cf_flow_driver_read(cf_flow_driver_t *driver, cf_estimator_t *estimator,
                         const cf_flow_reading_t *reading, uint32_t tick);

// Group motion. Offsets count from cf_flow_driver_t.
cf_variables_t cf_flow_driver_parameters(void);
cf_variables_t cf_flow_driver_logs(void);

#endif  // CF_ONBOARD_DECKS_FLOW_DRIVER_H
