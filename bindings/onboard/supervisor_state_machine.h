/* The states of the supervisor, the conditions it looks at, and the table of transitions.
 *
 * Source: docs/reference/planner-commander.md#14.1, #14.4 and #14.5. The spin-up state "arming" of
 * the trees of mid 2026 is left out, as docs/reference/planner-commander.md#14.9 recommends for
 * vehicles without motor speed telemetry. */
#ifndef CF_ONBOARD_SUPERVISOR_STATE_MACHINE_H
#define CF_ONBOARD_SUPERVISOR_STATE_MACHINE_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
  supervisorStateNotInitialized       = 0,
  supervisorStatePreFlChecksNotPassed = 1,
  supervisorStatePreFlChecksPassed    = 2,
  supervisorStateReadyToFly           = 3,
  supervisorStateFlying               = 4,
  supervisorStateLanded               = 5,
  supervisorStateReset                = 6,
  supervisorStateWarningLevelOut      = 7,
  supervisorStateExceptFreeFall       = 8,
  supervisorStateLocked               = 9,
  supervisorStateCrashed              = 10,
  supervisorState_NrOfStates          = 11,
} supervisorState_t;

// Condition n is bit 1 << n of a set of conditions.
typedef enum {
  CF_CONDITION_ARMED                 = 0,
  CF_CONDITION_IS_FLYING             = 1,
  CF_CONDITION_IS_TUMBLED            = 2,
  CF_CONDITION_COMMANDER_WDT_WARNING = 3,
  CF_CONDITION_COMMANDER_WDT_TIMEOUT = 4,
  CF_CONDITION_EMERGENCY_STOP        = 5,
  CF_CONDITION_CRASHED               = 6,
  CF_CONDITION_PREFLIGHT_TIMEOUT     = 7,
  CF_CONDITION_LANDING_TIMEOUT       = 8,
  CF_CONDITION_COUNT                 = 9,
} cf_condition_t;

// The same as sets of one condition, with the firmware's names.
#define SUPERVISOR_CB_NONE 0
#define SUPERVISOR_CB_ARMED 1
#define SUPERVISOR_CB_IS_FLYING 2
#define SUPERVISOR_CB_IS_TUMBLED 4
#define SUPERVISOR_CB_COMMANDER_WDT_WARNING 8
#define SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT 16
#define SUPERVISOR_CB_EMERGENCY_STOP 32
#define SUPERVISOR_CB_CRASHED 64
#define SUPERVISOR_CB_PREFLIGHT_TIMEOUT 128
#define SUPERVISOR_CB_LANDING_TIMEOUT 256

// How a rule looks at the conditions.
typedef enum {
  supervisorAlways = 0,
  supervisorNever  = 1,
  supervisorAll    = 2,  // every one of `bits` is set and none of `negated`
  supervisorAny    = 3,  // one of `bits` is set, or one of `negated` is not
} supervisorConditionCombiner_t;

typedef struct {
  supervisorConditionCombiner_t combiner;
  uint32_t                      bits;
  uint32_t                      negated;
} supervisorRule_t;

// Taken when the trigger holds and the blocker does not.
typedef struct {
  supervisorState_t to;
  supervisorRule_t  trigger;
  supervisorRule_t  blocker;
} supervisorTransition_t;

typedef struct {
  const supervisorTransition_t *transitions;  // in order of priority
  int                           count;
} supervisorTransitionList_t;

// Returns the state that the first matching transition of the list leads to, or `state`.
supervisorState_t findTransition(supervisorState_t state, uint32_t conditions,
                                 const supervisorTransitionList_t *list);

// Returns the state that follows under these conditions: at most one transition of the table.
supervisorState_t supervisorStateUpdate(supervisorState_t state, uint32_t conditions);

// Return the firmware's names, or "" for a number that is none.
const char *supervisorGetStateName(supervisorState_t state);
const char *supervisorGetConditionName(cf_condition_t condition);

#endif  // CF_ONBOARD_SUPERVISOR_STATE_MACHINE_H
