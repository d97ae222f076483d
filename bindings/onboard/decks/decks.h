/* The expansion decks on one drone: which are there, and the drivers of those that position it. */
#ifndef CF_ONBOARD_DECKS_DECKS_H
#define CF_ONBOARD_DECKS_DECKS_H

#include <stdbool.h>
#include <stdint.h>

#include "onboard/decks/flow_driver.h"
#include "onboard/decks/lighthouse_deck.h"
#include "onboard/decks/loco_deck.h"
#include "onboard/decks/ranger_driver.h"
#include "positioning.h"
#include "variables.h"

// Whether a deck is mounted, as group `deck` of the parameters tells clients.
typedef struct {
  uint8_t flow2;        // bcFlow2, which carries a range finder
  uint8_t zranger2;     // bcZRanger2: that range finder, or one on a deck of its own
  uint8_t multiranger;  // bcMultiranger
  uint8_t lighthouse4;  // bcLighthouse4
  uint8_t loco;         // bcLoco, bcDWM1000
  uint8_t none;         // every other deck: 0
} cf_deck_flags_t;

typedef struct {
  cf_deck_flags_t      flags;
  cf_flow_driver_t     flow;
  cf_ranger_driver_t   ranger;
  cf_lighthouse_deck_t lighthouse;
  cf_loco_deck_t       loco;
} cf_decks_t;

// Writes the whole struct for the decks that a positioning system needs, at tick 0, and for those
// that only measure ranges.
void cf_decks_init(cf_decks_t *decks, cf_positioning_t positioning, bool has_zranger,
                   bool has_multiranger);

// Counts for the log, once per second.
void cf_decks_count(cf_decks_t *decks, const cf_base_stations_t *stations);

// Group deck. Offsets count from cf_decks_t.
cf_variables_t cf_decks_parameters(void);

#endif  // CF_ONBOARD_DECKS_DECKS_H
