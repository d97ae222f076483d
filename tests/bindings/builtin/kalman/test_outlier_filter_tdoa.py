"""Gate for differences of distances (docs/reference/estimators.md#6.1, #16.3 and #17.I)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib


def measured(difference: float, std_dev: float = 0.15) -> ffi.CData:
    """Return a sample of two anchors 4 m apart."""
    anchors = [{"x": 1.0, "y": 1.0, "z": 1.0}, {"x": 5.0, "y": 1.0, "z": 1.0}]
    return ffi.new("tdoaMeasurement_t *", {"anchorPositions": anchors, "distanceDiff": difference, "stdDev": std_dev})


@pytest.fixture
def state():
    state = ffi.new("OutlierFilterTdoaState_t *")
    ffi.buffer(state)[:] = b"\xff" * ffi.sizeof("OutlierFilterTdoaState_t")
    lib.outlierFilterTdoaReset(state)
    return state


def test_reset_leaves_it_open_and_empty(state):
    assert (state.integrator, state.isFilterOpen, state.latestUpdateMs) == (0.0, True, 0)


@pytest.mark.parametrize(
    ("difference", "accepted"),
    [(1.0, True), (10.0, False), (-10.0, False), (4.0, False), (-4.0, False), (3.99, True), (math.nan, False)],
)
def test_a_difference_beyond_the_distance_of_the_anchors_is_impossible(state, difference, accepted):
    """docs/reference/estimators.md#16.3, and that an impossible sample leaves no trace."""
    before = ffi.buffer(state)[:]
    assert lib.outlierFilterTdoaValidateIntegrator(state, measured(difference), 0.0, 1000) == accepted
    assert (ffi.buffer(state)[:] == before) == (not accepted)


def test_check_vector_i(state):
    errors = [0.1] * 12 + [1.0] * 12 + [0.1] * 3
    integrators = [30, *range(55, 281, 25), 300, *range(275, -1, -25), 25, 50, 75]
    accepted = [True] * 12 + [False] * 11 + [True] * 4
    is_open = [True] * 10 + [False] * 12 + [True] * 5

    found = []
    for i, error in enumerate(errors):
        result = lib.outlierFilterTdoaValidateIntegrator(state, measured(0.5), error, 1000 + 25 * i)
        found.append((result, state.integrator, state.isFilterOpen))
    assert found == list(zip(accepted, integrators, is_open, strict=True))


def test_closed_it_accepts_up_to_two_and_a_half_deviations(state):
    for error, accepted, fills in [(0.29, True, True), (0.31, True, False), (0.38, False, False)]:
        state.isFilterOpen, state.integrator, state.latestUpdateMs = False, 200.0, 990
        assert lib.outlierFilterTdoaValidateIntegrator(state, measured(0.5), -error, 1000) == accepted
        assert state.integrator == (210.0 if fills else 190.0)


def test_a_long_silence_counts_as_30_ms(state):
    lib.outlierFilterTdoaValidateIntegrator(state, measured(0.5), 0.0, 4_000_000_000)
    assert state.integrator == 30.0
    lib.outlierFilterTdoaValidateIntegrator(state, measured(0.5), 0.0, 4_000_000_007)
    assert (state.integrator, state.latestUpdateMs) == (37.0, 4_000_000_007)


anything = st.floats(width=32)


@given(st.lists(st.tuples(anything, anything, anything, st.integers(0, 2**32 - 1)), max_size=30))
def test_the_reservoir_stays_within_its_walls(samples):
    state = ffi.new("OutlierFilterTdoaState_t *")
    lib.outlierFilterTdoaReset(state)
    for difference, std_dev, error, now_ms in samples:
        lib.outlierFilterTdoaValidateIntegrator(state, measured(difference, std_dev), error, now_ms)
        assert 0.0 <= state.integrator <= 300.0
