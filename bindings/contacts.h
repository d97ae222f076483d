/* What a drone touches: stored in the drone's state, so that the beginning of a contact is reported
 * once, also after a flight was restored. The collision detection of the simulator fills it. */
#ifndef CF_CONTACTS_H
#define CF_CONTACTS_H

#include <stdbool.h>
#include <stdint.h>

#include "variables.h"

#define CF_MOST_TOUCHED 12

typedef struct {
  uint32_t thing;    // number of what is touched, from 1; 0: nothing
  uint32_t last_ms;  // simulated time at which it was touched last
} cf_touched_t;

typedef struct {
  cf_touched_t touched[CF_MOST_TOUCHED];
  uint32_t     tick;   // onboard tick at the end of the step that `count` belongs to
  uint8_t      count;  // points of contact in that step
  uint8_t      now;    // sim.contacts: the same, or 0 when that step is over
} cf_contacts_t;

// Pure: a simulated time [s] as contacts remember it [ms]. It may be negative, and wraps.
uint32_t cf_contacts_clock(double time);

// Notes one point of contact with a thing at a simulated time, in the step that ends with an
// onboard tick. Returns true when this contact begins: the thing was not touched for 0.2 s, longer
// than a drone bounces off.
bool cf_contacts_note(cf_contacts_t *contacts, uint32_t thing, uint32_t now_ms, uint32_t tick);

// The drone is held where it lies and its contacts are not looked for: those of the last 0.2 s go
// on in the step that ends with an onboard tick.
void cf_contacts_go_on(cf_contacts_t *contacts, uint32_t now_ms, uint32_t tick);

// Brings sim.contacts up to date.
void cf_contacts_refresh(cf_contacts_t *contacts, uint32_t tick);

// Log variable sim.contacts. Offsets count from cf_contacts_t.
cf_variables_t cf_contacts_logs(void);

#endif  // CF_CONTACTS_H
