/* The commander: holds the one setpoint that is flown, and lets only its owner change it.
 *
 * Source: docs/reference/planner-commander.md#8. Ticks are [ms]. */
#ifndef CF_ONBOARD_COMMANDER_COMMANDER_H
#define CF_ONBOARD_COMMANDER_COMMANDER_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "onboard/commander/high_level_commander.h"
#include "provider.h"
#include "variables.h"

#define COMMANDER_PRIORITY_DISABLE 0
#define COMMANDER_PRIORITY_LOWEST 1
#define COMMANDER_PRIORITY_HIGHLEVEL 1
#define COMMANDER_PRIORITY_CRTP 2
#define COMMANDER_PRIORITY_EXTRX 3

typedef struct {
  uint8_t enHighLevel;  // param commander.enHighLevel, without effect

  setpoint_t setpoint;  // initially null; its timestamp tells when it was set
  int        priority;  // of the source that set it last
  uint32_t   last_update;
} cf_commander_t;

void cf_commander_init(cf_commander_t *commander, uint32_t now);

// Stamps and stores a setpoint, and returns true, unless a higher priority is active. A priority
// above the high-level commander's stops the provider's planner.
bool cf_commander_set_setpoint(cf_commander_t *commander, const cf_provider_t *provider,
                               void *provider_state, const setpoint_t *setpoint, int priority,
                               uint32_t now);

// Gives way to the high-level commander, whose plans will start at this estimate. Its planner is
// stopped then: a command has to follow within its 10 ms or the motors stop.
void cf_commander_relax_priority(cf_commander_t            *commander,
                                 cf_high_level_commander_t *high_level_commander,
                                 const state_t             *estimate);

void cf_commander_get_setpoint(cf_commander_t *commander, setpoint_t *setpoint);

// Returns how old the setpoint was at the last get [ms].
uint32_t cf_commander_inactivity_time(const cf_commander_t *commander, uint32_t now);
int      cf_commander_active_priority(const cf_commander_t *commander);

cf_variables_t cf_commander_parameters(void);  // commander.enHighLevel

#endif  // CF_ONBOARD_COMMANDER_COMMANDER_H
