#include "onboard/supervisor_state_machine.h"

#include <stddef.h>

#define ALWAYS {supervisorAlways, 0, 0}
#define NEVER {supervisorNever, 0, 0}
#define ALL(bits_) {supervisorAll, (bits_), 0}
#define ANY(bits_) {supervisorAny, (bits_), 0}
#define NONE(negated_) {supervisorAll, 0, (negated_)}
#define ANY_OR_NOT(bits_, negated_) {supervisorAny, (bits_), (negated_)}

// Rows: where to, trigger, blocker; the first that matches wins.
// docs/reference/planner-commander.md#14.5.

static const supervisorTransition_t NOT_INITIALIZED[] = {
    {supervisorStatePreFlChecksNotPassed, ALWAYS, NEVER},
};

static const supervisorTransition_t PRE_FLIGHT_CHECKS_NOT_PASSED[] = {
    {supervisorStateExceptFreeFall, ALL(SUPERVISOR_CB_EMERGENCY_STOP), NEVER},
    {supervisorStatePreFlChecksPassed, ALWAYS, ALL(SUPERVISOR_CB_IS_TUMBLED)},
};

static const supervisorTransition_t PRE_FLIGHT_CHECKS_PASSED[] = {
    {supervisorStateExceptFreeFall, ALL(SUPERVISOR_CB_EMERGENCY_STOP), NEVER},
    {supervisorStatePreFlChecksNotPassed, ALL(SUPERVISOR_CB_IS_TUMBLED), NEVER},
    {supervisorStateReadyToFly, ALL(SUPERVISOR_CB_ARMED), ALL(SUPERVISOR_CB_IS_TUMBLED)},
};

static const supervisorTransition_t READY_TO_FLY[] = {
    {supervisorStateExceptFreeFall, ALL(SUPERVISOR_CB_EMERGENCY_STOP), NEVER},
    {supervisorStatePreFlChecksNotPassed,
     ANY_OR_NOT(SUPERVISOR_CB_IS_TUMBLED | SUPERVISOR_CB_PREFLIGHT_TIMEOUT, SUPERVISOR_CB_ARMED),
     NEVER},
    {supervisorStateFlying, ALL(SUPERVISOR_CB_IS_FLYING), NEVER},
};

static const supervisorTransition_t FLYING[] = {
    {supervisorStateExceptFreeFall,
     ANY(SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT | SUPERVISOR_CB_EMERGENCY_STOP), NEVER},
    {supervisorStateCrashed, ALL(SUPERVISOR_CB_IS_TUMBLED), NEVER},
    {supervisorStateReset, NONE(SUPERVISOR_CB_ARMED), NEVER},
    {supervisorStateWarningLevelOut, ALL(SUPERVISOR_CB_COMMANDER_WDT_WARNING), NEVER},
    {supervisorStateLanded, NONE(SUPERVISOR_CB_IS_FLYING), NEVER},
};

static const supervisorTransition_t LANDED[] = {
    {supervisorStateReset, ANY_OR_NOT(SUPERVISOR_CB_LANDING_TIMEOUT, SUPERVISOR_CB_ARMED), NEVER},
    {supervisorStateFlying, ALL(SUPERVISOR_CB_IS_FLYING), NEVER},
};

static const supervisorTransition_t RESET[] = {
    {supervisorStatePreFlChecksNotPassed, ALWAYS, NEVER},
};

static const supervisorTransition_t WARNING_LEVEL_OUT[] = {
    {supervisorStateExceptFreeFall,
     ANY(SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT | SUPERVISOR_CB_IS_TUMBLED |
         SUPERVISOR_CB_EMERGENCY_STOP),
     NEVER},
    {supervisorStateFlying,
     NONE(SUPERVISOR_CB_COMMANDER_WDT_WARNING | SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT), NEVER},
};

static const supervisorTransition_t EXCEPT_FREE_FALL[] = {
    {supervisorStateLocked, ALWAYS, NEVER},
};

static const supervisorTransition_t CRASHED[] = {
    {supervisorStatePreFlChecksNotPassed, NONE(SUPERVISOR_CB_CRASHED | SUPERVISOR_CB_IS_TUMBLED),
     NEVER},
    {supervisorStateLocked, ALL(SUPERVISOR_CB_EMERGENCY_STOP), NEVER},
};

#define LIST(rows_) {rows_, (int)(sizeof(rows_) / sizeof((rows_)[0]))}

static const supervisorTransitionList_t TRANSITIONS[supervisorState_NrOfStates] = {
    [supervisorStateNotInitialized]       = LIST(NOT_INITIALIZED),
    [supervisorStatePreFlChecksNotPassed] = LIST(PRE_FLIGHT_CHECKS_NOT_PASSED),
    [supervisorStatePreFlChecksPassed]    = LIST(PRE_FLIGHT_CHECKS_PASSED),
    [supervisorStateReadyToFly]           = LIST(READY_TO_FLY),
    [supervisorStateFlying]               = LIST(FLYING),
    [supervisorStateLanded]               = LIST(LANDED),
    [supervisorStateReset]                = LIST(RESET),
    [supervisorStateWarningLevelOut]      = LIST(WARNING_LEVEL_OUT),
    [supervisorStateExceptFreeFall]       = LIST(EXCEPT_FREE_FALL),
    [supervisorStateLocked]               = {NULL, 0},  // only a restart leaves it
    [supervisorStateCrashed]              = LIST(CRASHED),
};

static const char *const STATE_NAMES[supervisorState_NrOfStates] = {
    [supervisorStateNotInitialized]       = "Not initialized",
    [supervisorStatePreFlChecksNotPassed] = "Pre-flight checks not passed",
    [supervisorStatePreFlChecksPassed]    = "Pre-flight checks passed",
    [supervisorStateReadyToFly]           = "Ready to fly",
    [supervisorStateFlying]               = "Flying",
    [supervisorStateLanded]               = "Landed",
    [supervisorStateReset]                = "Reset",
    [supervisorStateWarningLevelOut]      = "Warning, level out",
    [supervisorStateExceptFreeFall]       = "Exception, free fall",
    [supervisorStateLocked]               = "Locked",
    [supervisorStateCrashed]              = "Crashed",
};

static const char *const CONDITION_NAMES[CF_CONDITION_COUNT] = {
    [CF_CONDITION_ARMED]                 = "armed",
    [CF_CONDITION_IS_FLYING]             = "isFlying",
    [CF_CONDITION_IS_TUMBLED]            = "isTumbled",
    [CF_CONDITION_COMMANDER_WDT_WARNING] = "commanderWdtWarning",
    [CF_CONDITION_COMMANDER_WDT_TIMEOUT] = "commanderWdtTimeout",
    [CF_CONDITION_EMERGENCY_STOP]        = "emergencyStop",
    [CF_CONDITION_CRASHED]               = "isCrashed",
    [CF_CONDITION_PREFLIGHT_TIMEOUT]     = "preflightTimeout",
    [CF_CONDITION_LANDING_TIMEOUT]       = "landingTimeout",
};

static bool holds(const supervisorRule_t *rule, uint32_t conditions) {
  const uint32_t set   = conditions & rule->bits;
  const uint32_t clear = ~conditions & rule->negated;
  switch (rule->combiner) {
    case supervisorAlways:
      return true;
    case supervisorNever:
      return false;
    case supervisorAll:
      return set == rule->bits && clear == rule->negated;
    case supervisorAny:
      return set != 0 || clear != 0;
  }
  return false;
}

static bool is_state(supervisorState_t state) {
  return (int)state >= 0 && state < supervisorState_NrOfStates;
}

supervisorState_t findTransition(supervisorState_t state, uint32_t conditions,
                                 const supervisorTransitionList_t *list) {
  for (int i = 0; i < list->count; i++) {
    const supervisorTransition_t *transition = &list->transitions[i];
    if (holds(&transition->trigger, conditions) && !holds(&transition->blocker, conditions)) {
      return transition->to;
    }
  }
  return state;
}

supervisorState_t supervisorStateUpdate(supervisorState_t state, uint32_t conditions) {
  return is_state(state) ? findTransition(state, conditions, &TRANSITIONS[state]) : state;
}

const char *supervisorGetStateName(supervisorState_t state) {
  return is_state(state) ? STATE_NAMES[state] : "";
}

const char *supervisorGetConditionName(cf_condition_t condition) {
  return (int)condition >= 0 && condition < CF_CONDITION_COUNT ? CONDITION_NAMES[condition] : "";
}
