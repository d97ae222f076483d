#include "contacts.h"

#include <math.h>

#include "variable_row.h"

#define HOLD_MS 200u

uint32_t cf_contacts_clock(double time) {
  return (uint32_t)(int64_t)floor(time * 1e3 + 0.5);
}

bool cf_contacts_note(cf_contacts_t *contacts, uint32_t thing, uint32_t now_ms, uint32_t tick) {
  if (contacts->tick != tick) {
    contacts->tick  = tick;
    contacts->count = 0;
  }
  contacts->count = contacts->count < UINT8_MAX ? (uint8_t)(contacts->count + 1) : UINT8_MAX;

  // where nothing fits, what was touched longest ago is forgotten
  cf_touched_t *place = &contacts->touched[0];
  for (int i = 0; i < CF_MOST_TOUCHED; i++) {
    cf_touched_t *other = &contacts->touched[i];
    if (other->thing == thing) {
      const bool begins = now_ms - other->last_ms > HOLD_MS;
      other->last_ms    = now_ms;
      return begins;
    }
    const bool is_older = other->thing == 0 || other->last_ms < place->last_ms;
    place               = place->thing != 0 && is_older ? other : place;
  }
  *place = (cf_touched_t){.thing = thing, .last_ms = now_ms};
  return true;
}

void cf_contacts_go_on(cf_contacts_t *contacts, uint32_t now_ms, uint32_t tick) {
  for (int i = 0; i < CF_MOST_TOUCHED; i++) {
    cf_touched_t *touched = &contacts->touched[i];
    if (touched->thing != 0 && now_ms - touched->last_ms <= HOLD_MS) {
      touched->last_ms = now_ms;
    }
  }
  contacts->tick = tick;  // with the points of contact that there were, or those of this step
}

void cf_contacts_refresh(cf_contacts_t *contacts, uint32_t tick) {
  contacts->now = contacts->tick == tick ? contacts->count : 0;
}

static const cf_variable_t LOGS[] = {
    CF_ROW("sim", "contacts", UINT8, 0, cf_contacts_t, now),
};

cf_variables_t cf_contacts_logs(void) {
  return CF_TABLE(LOGS);
}
