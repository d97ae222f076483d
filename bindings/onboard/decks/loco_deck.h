/* Driver of the loco positioning deck: rangings in, measurements for the estimator out.
 *
 * Standard deviations are those of the firmware: 0.25 m for a distance, 0.15 m for a difference
 * (docs/reference/estimators.md#13.5). In two dimensions every ranging brings the known height
 * along; the firmware chooses that when it is built. */
#ifndef CF_ONBOARD_DECKS_LOCO_DECK_H
#define CF_ONBOARD_DECKS_LOCO_DECK_H

#include <stdbool.h>
#include <stdint.h>

#include "deck_facts.h"
#include "onboard/estimator.h"
#include "variables.h"

#define CF_STREAMED_RANGES 16

// The latest distances (TWR), written while they are streamed; the reader remembers how many it has
// read.
typedef struct {
  uint32_t written;                        // range n is at n modulo CF_STREAMED_RANGES
  float    distances[CF_STREAMED_RANGES];  // [m]
  uint8_t  anchors[CF_STREAMED_RANGES];
} cf_streamed_ranges_t;

typedef struct {
  // parameters
  uint8_t mode;       // cf_loco_mode_t; CF_LOCO_AUTO takes whatever the anchors speak
  float   tdoa2_std;  // [m]
  float   tdoa3_std;  // [m]
  uint8_t streams;    // locSrv.enRangeStreamFP32: distances are kept for clients

  // log
  float    distances[CF_LOCO_ANCHORS];  // [m], of the latest ranges (TWR)
  uint16_t state;                       // bit i: received from anchor i within the last second

  // settings
  float anchors[CF_LOCO_ANCHORS][3];  // [m], world
  bool  is_planar;                    // two dimensions
  float height;                       // [m], in two dimensions

  uint16_t heard;  // bit i: anchor i since the last count

  cf_streamed_ranges_t streamed;
} cf_loco_deck_t;

// Writes the whole struct; anchors at the origin, three dimensions.
void cf_loco_deck_init(cf_loco_deck_t *deck);

// Takes a ranging at a tick [ms] and enqueues what follows from it. One of another mode than the
// parameter says is ignored.
void cf_loco_deck_ranging(cf_loco_deck_t *deck, cf_estimator_t *estimator,
                          const cf_ranging_t *ranging, uint32_t tick);

// Counts for the log, once per second.
void cf_loco_deck_count(cf_loco_deck_t *deck);

// Groups loco, tdoa2 and tdoa3; ranging. Offsets count from cf_loco_deck_t.
cf_variables_t cf_loco_deck_parameters(void);
cf_variables_t cf_loco_deck_logs(void);

#endif  // CF_ONBOARD_DECKS_LOCO_DECK_H
