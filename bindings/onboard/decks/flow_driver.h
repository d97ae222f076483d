/* Driver of the flow deck: registers in, ranges and flow for the estimator out.
 *
 * Estimators dossier sections 13.1 and 13.2. */
#ifndef CF_ONBOARD_DECKS_FLOW_DRIVER_H
#define CF_ONBOARD_DECKS_FLOW_DRIVER_H

#include <stdint.h>

#include "deck_facts.h"
#include "onboard/estimator.h"
#include "variables.h"

// Where a distance may point, in the order of the log.
typedef enum {
  CF_RANGE_FRONT = 0,
  CF_RANGE_BACK  = 1,
  CF_RANGE_UP    = 2,
  CF_RANGE_LEFT  = 3,
  CF_RANGE_RIGHT = 4,
  CF_RANGE_DOWN  = 5,
  CF_RANGE_COUNT = 6,
} cf_range_direction_t;

typedef struct {
  // parameters
  uint8_t disable;    // not 0: flow does not reach the estimator
  uint8_t adaptive;   // not 0: the standard deviation follows the shutter
  float   fixed_std;  // [counts], otherwise

  // log
  cf_flow_reading_t reading;                 // the latest registers
  uint16_t          ranges[CF_RANGE_COUNT];  // [mm]
  float             std;                     // [counts], told with the latest flow
  uint8_t           outliers;                // readings of 100 counts and more; wraps around
  uint8_t           unused[3];               // brightness registers that are not simulated: 0

  uint32_t last_tick;  // [ms], of the latest reading that was no outlier
} cf_flow_driver_t;

// Writes the whole struct at a tick [ms], one before the first that is sensed.
void cf_flow_driver_init(cf_flow_driver_t *driver, uint32_t now_ms);

// Takes the registers named by `what` (CF_FLOW_DECK_RANGE | CF_FLOW_DECK_FLOW) at a tick [ms] and
// enqueues what follows from them: ranges below 5 m, flow that moved and was no outlier.
void cf_flow_driver_read(cf_flow_driver_t *driver, cf_estimator_t *estimator, int what,
                         const cf_flow_reading_t *reading, uint32_t tick);

// Group motion; groups motion and range. Offsets count from cf_flow_driver_t.
cf_variables_t cf_flow_driver_parameters(void);
cf_variables_t cf_flow_driver_logs(void);

#endif  // CF_ONBOARD_DECKS_FLOW_DRIVER_H
