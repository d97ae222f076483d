// States of the supervisor, and which conditions lead from one to another.
#include "supervisor_state_machine.h"

#include <assert.h>
#include <stdbool.h>

#include "platform_defaults.h"
#include "test_support.h"

#ifdef DEBUG_ME
#define DEBUG_MODULE "SUPST"
#include "cfassert.h"
#include "debug.h"
#endif

static const char *const stateNames[] = {
    "Not initialized",
    "Pre-flight checks not passed",
    "Pre-flight checks passed",
    "Ready to fly",
    "Flying",
    "Landed",
    "Reset",
    "Warning, level out",
    "Exception, free fall",
    "Locked",
    "Crashed",
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
    "Arming",
#endif
#endif
};
static_assert(sizeof(stateNames) / sizeof(stateNames[0]) == supervisorState_NrOfStates);

static const char *const conditionNames[] = {
    "armed",
    "isFlying",
    "isTumbled",
    "commanderWdtWarning",
    "commanderWdtTimeout",
    "emergencyStop",
    "isCrashed",
#if MINIATURE_RELEASE >= 202512
    "preflightTimeout",
#endif
    "landingTimeout",
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
    "rpmAtArmingValid",
    "spinupTimeout",
#endif
#endif
};
static_assert(sizeof(conditionNames) / sizeof(conditionNames[0]) ==
              supervisorCondition_NrOfConditions);

// Of each state, in order of priority.

static SupervisorStateTransition_t transitionsNotInitialized[] = {
    {
        .newState        = supervisorStatePreFlChecksNotPassed,
        .triggerCombiner = supervisorAlways,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsPreFlChecksNotPassed[] = {
    {
        .newState        = supervisorStateExceptFreeFall,
        .triggers        = SUPERVISOR_CB_EMERGENCY_STOP,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStatePreFlChecksPassed,
        .triggerCombiner = supervisorAlways,
        .blockers        = SUPERVISOR_CB_IS_TUMBLED,
        .blockerCombiner = supervisorAll,
    },
};

static SupervisorStateTransition_t transitionsPreFlChecksPassed[] = {
    {
        .newState        = supervisorStateExceptFreeFall,
        .triggers        = SUPERVISOR_CB_EMERGENCY_STOP,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStatePreFlChecksNotPassed,
        .triggers        = SUPERVISOR_CB_IS_TUMBLED,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
        .newState = supervisorStateArming,
#else
        .newState = supervisorStateReadyToFly,
#endif
#else
        .newState = supervisorStateReadyToFly,
#endif
        .triggers        = SUPERVISOR_CB_ARMED,
        .triggerCombiner = supervisorAll,
        .blockers        = SUPERVISOR_CB_IS_TUMBLED,
        .blockerCombiner = supervisorAll,
    },
};

#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
static SupervisorStateTransition_t transitionsArming[] = {
    {
        .newState        = supervisorStateExceptFreeFall,
        .triggers        = SUPERVISOR_CB_EMERGENCY_STOP,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStatePreFlChecksNotPassed,
        .triggers        = SUPERVISOR_CB_IS_TUMBLED | SUPERVISOR_CB_SPINUP_TIMEOUT,
        .negatedTriggers = SUPERVISOR_CB_ARMED,
        .triggerCombiner = supervisorAny,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStateReadyToFly,
        .triggers        = SUPERVISOR_CB_RPM_AT_ARMING_VALID,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
};

#endif
#endif
static SupervisorStateTransition_t transitionsReadyToFly[] = {
    {
        .newState        = supervisorStateExceptFreeFall,
        .triggers        = SUPERVISOR_CB_EMERGENCY_STOP,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState = supervisorStatePreFlChecksNotPassed,
#if MINIATURE_RELEASE >= 202512
        .triggers = SUPERVISOR_CB_IS_TUMBLED | SUPERVISOR_CB_PREFLIGHT_TIMEOUT,
#else
        .triggers = SUPERVISOR_CB_IS_TUMBLED,
#endif
        .negatedTriggers = SUPERVISOR_CB_ARMED,
        .triggerCombiner = supervisorAny,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStateFlying,
        .triggers        = SUPERVISOR_CB_IS_FLYING,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsFlying[] = {
    {
        .newState = supervisorStateExceptFreeFall,
        .triggers = SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT | SUPERVISOR_CB_EMERGENCY_STOP,
#if MINIATURE_RELEASE >= 202512
#else
        .negatedTriggers = SUPERVISOR_CB_ARMED,
#endif
        .triggerCombiner = supervisorAny,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStateCrashed,
        .triggers        = SUPERVISOR_CB_IS_TUMBLED,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
#if MINIATURE_RELEASE >= 202512
    {
        .newState        = supervisorStateReset,
        .negatedTriggers = SUPERVISOR_CB_ARMED,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
#endif
    {
        .newState        = supervisorStateWarningLevelOut,
        .triggers        = SUPERVISOR_CB_COMMANDER_WDT_WARNING,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStateLanded,
        .negatedTriggers = SUPERVISOR_CB_IS_FLYING,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsLanded[] = {
    {
        .newState = supervisorStateReset,
        .triggers = SUPERVISOR_CB_LANDING_TIMEOUT,
#if MINIATURE_RELEASE >= 202512
        .negatedTriggers = SUPERVISOR_CB_ARMED,
#endif
        .triggerCombiner = supervisorAny,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStateFlying,
        .triggers        = SUPERVISOR_CB_IS_FLYING,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsReset[] = {
    {
        .newState        = supervisorStatePreFlChecksNotPassed,
        .triggerCombiner = supervisorAlways,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsWarningLevelOut[] = {
    {
        .newState        = supervisorStateExceptFreeFall,
        .triggers        = SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT | SUPERVISOR_CB_IS_TUMBLED |
                           SUPERVISOR_CB_EMERGENCY_STOP,
        .triggerCombiner = supervisorAny,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState = supervisorStateFlying,
        .negatedTriggers =
            SUPERVISOR_CB_COMMANDER_WDT_WARNING | SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsExceptFreeFall[] = {
    {
        .newState        = supervisorStateLocked,
        .triggerCombiner = supervisorAlways,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsLocked[] = {
    {
        .newState        = supervisorStateLocked,
        .triggerCombiner = supervisorNever,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransition_t transitionsCrashed[] = {
    {
        .newState        = supervisorStatePreFlChecksNotPassed,
        .negatedTriggers = SUPERVISOR_CB_CRASHED | SUPERVISOR_CB_IS_TUMBLED,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
    {
        .newState        = supervisorStateLocked,
        .triggers        = SUPERVISOR_CB_EMERGENCY_STOP,
        .triggerCombiner = supervisorAll,
        .blockerCombiner = supervisorNever,
    },
};

static SupervisorStateTransitionList_t transitionLists[] = {
    SUPERVISOR_TRANSITION_ENTRY(transitionsNotInitialized),
    SUPERVISOR_TRANSITION_ENTRY(transitionsPreFlChecksNotPassed),
    SUPERVISOR_TRANSITION_ENTRY(transitionsPreFlChecksPassed),
    SUPERVISOR_TRANSITION_ENTRY(transitionsReadyToFly),
    SUPERVISOR_TRANSITION_ENTRY(transitionsFlying),
    SUPERVISOR_TRANSITION_ENTRY(transitionsLanded),
    SUPERVISOR_TRANSITION_ENTRY(transitionsReset),
    SUPERVISOR_TRANSITION_ENTRY(transitionsWarningLevelOut),
    SUPERVISOR_TRANSITION_ENTRY(transitionsExceptFreeFall),
    SUPERVISOR_TRANSITION_ENTRY(transitionsLocked),
    SUPERVISOR_TRANSITION_ENTRY(transitionsCrashed),
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
    SUPERVISOR_TRANSITION_ENTRY(transitionsArming),
#endif
#endif
};
static_assert(sizeof(transitionLists) / sizeof(transitionLists[0]) == supervisorState_NrOfStates);

static bool areConditionsMet(const supervisorConditionCombiner_t combiner,
                             const supervisorConditionBits_t     bits,
                             const supervisorConditionBits_t     negatedBits,
                             const supervisorConditionBits_t     conditions) {
  switch (combiner) {
    case supervisorAlways:
      return true;
    case supervisorAll:
      return (conditions & bits) == bits && (conditions & negatedBits) == 0;
    case supervisorAny:
      return (conditions & bits) != 0 || (~conditions & negatedBits) != 0;
    default:
      return false;
  }
}

TESTABLE_STATIC supervisorState_t findTransition(
    const supervisorState_t currentState, const supervisorConditionBits_t triggerBitField,
    const SupervisorStateTransitionList_t *transitions) {
  for (int i = 0; i < transitions->length; i++) {
    const SupervisorStateTransition_t *t = &transitions->transitionList[i];

    const bool triggered =
        areConditionsMet(t->triggerCombiner, t->triggers, t->negatedTriggers, triggerBitField);
    const bool blocked =
        areConditionsMet(t->blockerCombiner, t->blockers, t->negatedBlockers, triggerBitField);
    if (triggered && !blocked) {
      return t->newState;
    }
  }
  return currentState;
}

supervisorState_t supervisorStateUpdate(const supervisorState_t         currentState,
                                        const supervisorConditionBits_t conditions) {
  return findTransition(currentState, conditions, &transitionLists[currentState]);
}

const char *supervisorGetStateName(const supervisorState_t currentState) {
  return currentState < supervisorState_NrOfStates ? stateNames[currentState] : "";
}

const char *supervisorGetConditionName(const supervisorConditions_t condition) {
  return condition < supervisorCondition_NrOfConditions ? conditionNames[condition] : "";
}
