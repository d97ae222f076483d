"""The deprecated gate for differences of distances (docs/reference/estimators.md#6.2, #16.3 and #17.J)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

LEVELS = [0.4, 0.8, 1.2, 1.6, 2.0]  # m
NONE = len(LEVELS)


class Gate:
    """A fresh gate before which samples of two anchors 4 m apart stand."""

    def __init__(self) -> None:
        self.state = ffi.new("OutlierFilterTdoaStepsState_t *")
        anchors = [{"x": 1.0, "y": 1.0, "z": 1.0}, {"x": 5.0, "y": 1.0, "z": 1.0}]
        self.sample = ffi.new("tdoaMeasurement_t *", {"anchorPositions": anchors, "distanceDiff": 1.0})
        self.place = ffi.new("point_t *")

    def passes(self, error: float, jacobian: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> bool:
        slope = ffi.new("vector_t *", dict(zip("xyz", jacobian, strict=True)))
        return lib.outlierFilterTdoaValidateSteps(self.state, self.sample, error, slope, self.place)

    def feed(self, error: float, count: int) -> list[bool]:
        return [self.passes(error) for _ in range(count)]


@pytest.fixture
def gate():
    return Gate()


def test_check_vector_j(gate):
    errors = [0.1, *[0.5] * 4, *[3.0] * 3, *[0.1] * 5]
    accepted = [1, *(0, 0, 1, 1), *(0, 0, 1), *[1] * 5]
    assert [int(gate.passes(error)) for error in errors] == accepted


@pytest.mark.parametrize(("difference", "accepted"), [(1.0, True), (10.0, False), (-10.0, False), (4.0, False)])
def test_a_difference_beyond_the_distance_of_the_anchors_is_impossible(gate, difference, accepted):
    """docs/reference/estimators.md#16.3; and it changes nothing."""
    before = ffi.buffer(gate.state)[:]
    gate.sample.distanceDiff = difference
    assert gate.passes(0.0) == accepted
    assert (ffi.buffer(gate.state)[:] == before) == (not accepted)


@pytest.mark.parametrize(("level", "error"), [(0, 0.39), (1, 0.79), (2, 1.19), (3, 1.59), (4, 1.99), (NONE, 2.01)])
def test_third_sample_beyond_a_tolerance_opens_the_next_one(gate, level, error):
    gate.feed(error, 2)
    assert gate.state.level == 0
    assert gate.passes(error)
    assert gate.state.level == level
    assert gate.state.acceptanceLevel == pytest.approx([*LEVELS, 100.0][level])


def test_tolerance_falls_back_after_thirty_samples(gate):
    gate.feed(1.0, 3)
    assert (gate.state.level, gate.state.closeDelay) == (2, 30)
    gate.feed(0.1, 30)
    assert (gate.state.level, gate.state.closeDelay) == (2, 0)
    gate.passes(0.1)
    assert gate.state.level == 0


def test_buckets_hold_ten(gate):
    gate.feed(9.0, 20)
    assert list(gate.state.buckets) == [10] * 5
    gate.feed(0.1, 20)
    assert list(gate.state.buckets) == [0] * 5


def test_innovation_counts_by_the_move_that_would_explain_it(gate):
    assert gate.passes(0.7, (0.0, -1.2, 1.6))
    assert gate.state.errorDistance == pytest.approx(0.35)
    assert not gate.passes(-0.9, (0.0, -1.2, 1.6))
    assert gate.state.errorDistance == pytest.approx(0.45)


@given(st.lists(st.tuples(st.floats(width=32), st.floats(width=32)), max_size=40))
def test_whatever_comes_the_state_stays_within_its_bounds(samples):
    gate = Gate()
    for error, slope in samples:
        gate.passes(error, (slope, 0.0, 0.0))
        assert all(0 <= bucket <= 10 for bucket in gate.state.buckets)
        assert 0 <= gate.state.level <= NONE
        assert 0 <= gate.state.closeDelay <= 30


def test_what_is_no_number_passes_only_when_everything_does(gate):
    assert gate.feed(math.nan, 3) == [False, False, True]
