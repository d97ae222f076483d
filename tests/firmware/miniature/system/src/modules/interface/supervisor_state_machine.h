#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef uint32_t supervisorConditionBits_t;

typedef enum {
  supervisorStateNotInitialized = 0,
  supervisorStatePreFlChecksNotPassed,
  supervisorStatePreFlChecksPassed,
  supervisorStateReadyToFly,
  supervisorStateFlying,
  supervisorStateLanded,
  supervisorStateReset,
  supervisorStateWarningLevelOut,
  supervisorStateExceptFreeFall,
  supervisorStateLocked,
  supervisorStateCrashed,
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
  supervisorStateArming,
#endif
#endif
  supervisorState_NrOfStates,
} supervisorState_t;

typedef enum {
  supervisorConditionArmed = 0,
  supervisorConditionIsFlying,
  supervisorConditionIsTumbled,
  supervisorConditionCommanderWdtWarning,
  supervisorConditionCommanderWdtTimeout,
  supervisorConditionEmergencyStop,
  supervisorConditionIsCrashed,
#if MINIATURE_RELEASE >= 202512
  supervisorConditionPreflightTimeout,
#endif
  supervisorConditionLandingTimeout,
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
  supervisorConditionRpmAtArmingValid,
  supervisorConditionSpinupTimeout,
#endif
#endif
  supervisorCondition_NrOfConditions,
} supervisorConditions_t;

#define SUPERVISOR_CB_NONE (0)
#define SUPERVISOR_CB_ARMED (1 << supervisorConditionArmed)
#define SUPERVISOR_CB_IS_FLYING (1 << supervisorConditionIsFlying)
#define SUPERVISOR_CB_IS_TUMBLED (1 << supervisorConditionIsTumbled)
#define SUPERVISOR_CB_COMMANDER_WDT_WARNING (1 << supervisorConditionCommanderWdtWarning)
#define SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT (1 << supervisorConditionCommanderWdtTimeout)
#define SUPERVISOR_CB_EMERGENCY_STOP (1 << supervisorConditionEmergencyStop)
#define SUPERVISOR_CB_CRASHED (1 << supervisorConditionIsCrashed)
#if MINIATURE_RELEASE >= 202512
#define SUPERVISOR_CB_PREFLIGHT_TIMEOUT (1 << supervisorConditionPreflightTimeout)
#endif
#define SUPERVISOR_CB_LANDING_TIMEOUT (1 << supervisorConditionLandingTimeout)
#if MINIATURE_RELEASE >= 202608
#ifdef CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL
#define SUPERVISOR_CB_RPM_AT_ARMING_VALID (1 << supervisorConditionRpmAtArmingValid)
#define SUPERVISOR_CB_SPINUP_TIMEOUT (1 << supervisorConditionSpinupTimeout)
#endif
#endif

// How bits are looked at. All: every one is set, and none of the negated ones. Any: one is set, or
// one of the negated ones is not.
typedef enum {
  supervisorAlways = 0,
  supervisorNever,
  supervisorAll,
  supervisorAny,
} supervisorConditionCombiner_t;

// Taken when the triggers hold and the blockers do not.
typedef struct {
  supervisorState_t newState;

  supervisorConditionBits_t     triggers;
  supervisorConditionBits_t     negatedTriggers;
  supervisorConditionCombiner_t triggerCombiner;

  supervisorConditionBits_t     blockers;
  supervisorConditionBits_t     negatedBlockers;
  supervisorConditionCombiner_t blockerCombiner;
} SupervisorStateTransition_t;

typedef struct {
  SupervisorStateTransition_t *transitionList;
  int                          length;
} SupervisorStateTransitionList_t;

#define SUPERVISOR_TRANSITION_ENTRY(TRANSITION_DEF) \
  {.transitionList = (TRANSITION_DEF),              \
   .length         = sizeof(TRANSITION_DEF) / sizeof((TRANSITION_DEF)[0])}

supervisorState_t supervisorStateUpdate(const supervisorState_t         currentState,
                                        const supervisorConditionBits_t conditions);
const char       *supervisorGetStateName(const supervisorState_t currentState);
const char       *supervisorGetConditionName(const supervisorConditions_t condition);
