#include "onboard/decks/decks.h"

#include "variable_row.h"

static cf_deck_flags_t flags_of(cf_positioning_t positioning) {
  switch (positioning) {
    case CF_POSITIONING_FLOW:
      return (cf_deck_flags_t){.flow2 = 1, .zranger2 = 1};
    case CF_POSITIONING_LIGHTHOUSE:
      return (cf_deck_flags_t){.lighthouse4 = 1};
    case CF_POSITIONING_LOCO_TWR:
    case CF_POSITIONING_LOCO_TDOA2:
    case CF_POSITIONING_LOCO_TDOA3:
      return (cf_deck_flags_t){.loco = 1};
    default:
      return (cf_deck_flags_t){0};
  }
}

void cf_decks_init(cf_decks_t *decks, cf_positioning_t positioning, bool has_zranger,
                   bool has_multiranger) {
  decks->flags             = flags_of(positioning);
  decks->flags.zranger2    = decks->flags.zranger2 || has_zranger;
  decks->flags.multiranger = has_multiranger;
  decks->ranger            = (cf_ranger_driver_t){.ranges = {0}};
  // sensors are read before the tick counts on: the first millisecond ends at tick 0
  cf_flow_driver_init(&decks->flow, UINT32_MAX);
  cf_lighthouse_deck_init(&decks->lighthouse);
  cf_loco_deck_init(&decks->loco);
}

void cf_decks_count(cf_decks_t *decks, const cf_base_stations_t *stations) {
  if (decks->flags.lighthouse4) {
    cf_lighthouse_deck_count(&decks->lighthouse, stations);
  }
  if (decks->flags.loco) {
    cf_loco_deck_count(&decks->loco);
  }
}

#define DECK(name_, member_) \
  CF_ROW("deck", name_, UINT8, CF_CORE | CF_READ_ONLY, cf_decks_t, flags.member_)

static const cf_variable_t PARAMETERS[] = {
    DECK("bcAI", none),           DECK("bcActiveMarker", none),
    DECK("bcBuzzer", none),       DECK("bcColorLedBot", none),
    DECK("bcColorLedTop", none),  DECK("bcDWM1000", loco),
    DECK("bcFlow", none),         DECK("bcFlow2", flow2),
    DECK("bcLedRing", none),      DECK("bcLighthouse4", lighthouse4),
    DECK("bcLoco", loco),         DECK("bcMultiranger", multiranger),
    DECK("bcUSD", none),          DECK("bcZRanger", none),
    DECK("bcZRanger2", zranger2),
};

cf_variables_t cf_decks_parameters(void) {
  return CF_TABLE(PARAMETERS);
}
