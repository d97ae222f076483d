"""The table of transitions and the rule that reads it (docs/reference/planner-commander.md#14 and #17.1)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from supervisor_states import (
    BOOT,
    CRASHED,
    FLYING,
    FREE_FALL,
    LANDED,
    LOCKED,
    NOT_PASSED,
    PASSED,
    READY,
    RESET,
    WARNING,
)

from crazychoir_fw._core import ffi, lib

A = lib.SUPERVISOR_CB_ARMED
F = lib.SUPERVISOR_CB_IS_FLYING
U = lib.SUPERVISOR_CB_IS_TUMBLED
W = lib.SUPERVISOR_CB_COMMANDER_WDT_WARNING
T = lib.SUPERVISOR_CB_COMMANDER_WDT_TIMEOUT
E = lib.SUPERVISOR_CB_EMERGENCY_STOP
C = lib.SUPERVISOR_CB_CRASHED
P = lib.SUPERVISOR_CB_PREFLIGHT_TIMEOUT
L = lib.SUPERVISOR_CB_LANDING_TIMEOUT
EVERY_CONDITION = A | F | U | W | T | E | C | P | L

ALWAYS, NEVER = lib.supervisorAlways, lib.supervisorNever
ALL, ANY = lib.supervisorAll, lib.supervisorAny


def is_taken(conditions: int, trigger: tuple[int, int, int], blocker: tuple[int, int, int]) -> bool:
    """Tell whether a list of one transition leads from state 1 to state 2."""
    row = ffi.new("supervisorTransition_t *", [PASSED, list(trigger), list(blocker)])
    transitions = ffi.new("supervisorTransitionList_t *", [row, 1])
    return lib.findTransition(NOT_PASSED, conditions, transitions) == PASSED


# docs/reference/planner-commander.md#17.1: conditions, combiner, bits, negated bits, is it taken
@pytest.mark.parametrize(
    ("conditions", "combiner", "bits", "negated", "taken"),
    [
        (123, ALWAYS, 0, 0, True),
        (123, NEVER, 0, 0, False),
        (W, ALL, W, 0, True),
        (A, ALL, W, 0, False),
        (W, ALL, 0, W, False),
        (0, ALL, 0, W, True),
        (W | A, ALL, W | A, 0, True),
        (W | A | E, ALL, W | A, 0, True),
        (W, ALL, W | A, 0, False),
        (W, ANY, W | A, 0, True),
        (0, ANY, W | A, 0, False),
        (A, ALL, 0, W | A, False),
        (0, ALL, 0, W | A, True),
        (T | U, ALL, T | U, W | A, True),
        (T, ALL, T | U, W | A, False),
        (T | U | W, ALL, T | U, W | A, False),
        (U | W | A, ANY, T | U, W | A, True),
        (F | A | W, ANY, T | U, F | A | W, False),
        (F | W, ANY, T | U, F | A | W, True),
    ],
)
def test_trigger_matches_upstream_test(conditions: int, combiner: int, bits: int, negated: int, taken: bool) -> None:
    assert is_taken(conditions, (combiner, bits, negated), (NEVER, 0, 0)) == taken
    # the same rule as a blocker has the opposite effect
    assert is_taken(conditions, (ALWAYS, 0, 0), (combiner, bits, negated)) != taken


@pytest.mark.parametrize(("combiner", "taken"), [(ALL, True), (ANY, False)])
def test_empty_sets_hold_for_all_and_fail_for_any(combiner: int, taken: bool) -> None:
    assert is_taken(0, (combiner, 0, 0), (NEVER, 0, 0)) == taken


def test_first_matching_transition_wins() -> None:
    always, never = [ALWAYS, 0, 0], [NEVER, 0, 0]
    rows = ffi.new(
        "supervisorTransition_t[]", [[FLYING, never, never], [LANDED, always, never], [RESET, always, never]]
    )
    assert lib.findTransition(READY, 0, ffi.new("supervisorTransitionList_t *", [rows, 3])) == LANDED


# docs/reference/planner-commander.md#14.5, each row of the table, and the order of rows where two match
@pytest.mark.parametrize(
    ("state", "conditions", "following"),
    [
        (BOOT, 0, NOT_PASSED),
        (BOOT, EVERY_CONDITION, NOT_PASSED),
        (NOT_PASSED, 0, PASSED),
        (NOT_PASSED, A, PASSED),
        (NOT_PASSED, U, NOT_PASSED),
        (NOT_PASSED, E, FREE_FALL),
        (NOT_PASSED, E | U, FREE_FALL),
        (PASSED, 0, PASSED),
        (PASSED, A, READY),
        (PASSED, U, NOT_PASSED),
        (PASSED, U | A, NOT_PASSED),
        (PASSED, E | A, FREE_FALL),
        (READY, A, READY),
        (READY, A | F, FLYING),
        (READY, 0, NOT_PASSED),
        (READY, F, NOT_PASSED),
        (READY, A | F | U, NOT_PASSED),
        (READY, A | F | P, NOT_PASSED),
        (READY, A | W | T, READY),
        (READY, A | E, FREE_FALL),
        (FLYING, A | F, FLYING),
        (FLYING, A | F | T, FREE_FALL),
        (FLYING, A | F | E, FREE_FALL),
        (FLYING, A | F | U | T, FREE_FALL),
        (FLYING, A | F | U, CRASHED),
        (FLYING, F | U, CRASHED),
        (FLYING, F, RESET),
        (FLYING, F | W, RESET),
        (FLYING, A | F | W, WARNING),
        (FLYING, A | W, WARNING),
        (FLYING, A, LANDED),
        (FLYING, A | F | P | L | C, FLYING),
        (LANDED, A, LANDED),
        (LANDED, A | L, RESET),
        (LANDED, 0, RESET),
        (LANDED, A | F | L, RESET),
        (LANDED, A | F, FLYING),
        (LANDED, A | U | W | T | E, LANDED),
        (RESET, 0, NOT_PASSED),
        (RESET, EVERY_CONDITION, NOT_PASSED),
        (WARNING, A | F | W, WARNING),
        (WARNING, A | F, FLYING),
        (WARNING, 0, FLYING),
        (WARNING, A | F | W | T, FREE_FALL),
        (WARNING, A | F | U, FREE_FALL),
        (WARNING, A | F | E, FREE_FALL),
        (FREE_FALL, 0, LOCKED),
        (FREE_FALL, EVERY_CONDITION, LOCKED),
        (LOCKED, 0, LOCKED),
        (LOCKED, EVERY_CONDITION, LOCKED),
        (CRASHED, 0, NOT_PASSED),
        (CRASHED, C, CRASHED),
        (CRASHED, U, CRASHED),
        (CRASHED, C | U | E, LOCKED),
        (CRASHED, E, NOT_PASSED),
    ],
)
def test_transition(state: int, conditions: int, following: int) -> None:
    assert lib.supervisorStateUpdate(state, conditions) == following


@given(st.integers(0, lib.supervisorState_NrOfStates - 1), st.integers(0, 2**32 - 1))
def test_conditions_that_do_not_exist_change_nothing(state: int, conditions: int) -> None:
    following = lib.supervisorStateUpdate(state, conditions)
    assert following == lib.supervisorStateUpdate(state, conditions & EVERY_CONDITION)


@pytest.mark.parametrize("state", [-1, 11, 2**31 - 1])
def test_number_that_is_no_state_stays(state: int) -> None:
    assert lib.supervisorStateUpdate(ffi.cast("supervisorState_t", state), A) == int(
        ffi.cast("supervisorState_t", state)
    )
    assert ffi.string(lib.supervisorGetStateName(ffi.cast("supervisorState_t", state))) == b""


STATE_NAMES = [
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
]


@pytest.mark.parametrize(("state", "name"), list(enumerate(STATE_NAMES)))
def test_state_has_a_name(state: int, name: str) -> None:
    assert ffi.string(lib.supervisorGetStateName(state)).decode() == name


CONDITION_NAMES = [
    "armed",
    "isFlying",
    "isTumbled",
    "commanderWdtWarning",
    "commanderWdtTimeout",
    "emergencyStop",
    "isCrashed",
    "preflightTimeout",
    "landingTimeout",
    "",
]


@pytest.mark.parametrize(("condition", "name"), list(enumerate(CONDITION_NAMES)))
def test_condition_has_a_name(condition: int, name: str) -> None:
    assert ffi.string(lib.supervisorGetConditionName(ffi.cast("cf_condition_t", condition))).decode() == name


def test_condition_sets_are_the_bits_of_the_conditions() -> None:
    assert [1 << n for n in range(lib.CF_CONDITION_COUNT)] == [A, F, U, W, T, E, C, P, L]
