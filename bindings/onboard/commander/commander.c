#include "onboard/commander/commander.h"

#include "variable_row.h"

void cf_commander_init(cf_commander_t *commander, uint32_t now) {
  *commander = (cf_commander_t){.priority = COMMANDER_PRIORITY_DISABLE, .last_update = now};
}

bool cf_commander_set_setpoint(cf_commander_t *commander, const cf_provider_t *provider,
                               void *provider_state, const setpoint_t *setpoint, int priority,
                               uint32_t now) {
  if (priority < commander->priority) {
    return false;
  }

  commander->setpoint           = *setpoint;
  commander->setpoint.timestamp = now;
  commander->priority           = priority;
  if (priority > COMMANDER_PRIORITY_HIGHLEVEL) {
    provider->plan_stop(provider_state);
  }
  return true;
}

void cf_commander_relax_priority(cf_commander_t            *commander,
                                 cf_high_level_commander_t *high_level_commander,
                                 const state_t             *estimate) {
  cf_high_level_commander_tell_state(high_level_commander, estimate);
  commander->priority = COMMANDER_PRIORITY_LOWEST;
}

void cf_commander_get_setpoint(cf_commander_t *commander, setpoint_t *setpoint) {
  *setpoint              = commander->setpoint;
  commander->last_update = setpoint->timestamp;
}

uint32_t cf_commander_inactivity_time(const cf_commander_t *commander, uint32_t now) {
  return now - commander->last_update;
}

int cf_commander_active_priority(const cf_commander_t *commander) {
  return commander->priority;
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("commander", "enHighLevel", UINT8, CF_CORE, cf_commander_t, enHighLevel),
};

cf_variables_t cf_commander_parameters(void) {
  return (cf_variables_t){PARAMETERS, (int)(sizeof PARAMETERS / sizeof PARAMETERS[0]), 0};
}
