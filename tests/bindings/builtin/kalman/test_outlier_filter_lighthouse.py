"""Gate for sweep angles (docs/reference/estimators.md#6.3 and #16.5)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

DISTANCE = 4.0  # [m]
GOOD, BAD = 0.0001, 1.0  # [rad]
STEP = 8  # [ms]


class Gate:
    """A filter reset at 1000 ms; the next sample comes at `now`."""

    def __init__(self) -> None:
        self.state = ffi.new("OutlierFilterLhState_t *")
        lib.outlierFilterLighthouseReset(self.state, 1000)
        self.now = 1008

    def passes(self, error: float) -> bool:
        """Offer one sample at `now`."""
        return lib.outlierFilterLighthouseValidateSweep(self.state, DISTANCE, error, self.now)

    def feed(self, error: float, count: int) -> list[bool]:
        """Offer samples 8 ms apart."""
        results = []
        for _ in range(count):
            results.append(self.passes(error))
            self.now += STEP
        return results


@pytest.fixture
def opened():
    return Gate()


@pytest.fixture
def closed():
    gate = Gate()
    gate.feed(GOOD, 20)
    assert gate.now == 1168
    return gate


def test_reset(opened):
    assert (opened.state.openingTimeMs, opened.state.openingWindowMs) == (1000, -16)


@pytest.mark.parametrize("error", [GOOD, BAD, -BAD])
def test_open_lets_everything_in(opened, error):
    assert opened.passes(error)


@pytest.mark.parametrize(("error", "passes"), [(GOOD, True), (-GOOD, True), (BAD, False), (-BAD, False)])
def test_closed_lets_only_good_samples_in(closed, error, passes):
    assert closed.passes(error) == passes


def test_ten_bad_samples_open_it_at_the_fifth(closed):
    assert closed.feed(BAD, 10) == [False] * 4 + [True] * 6


def test_a_long_silence_opens_it(closed):
    closed.now += 1600
    assert closed.passes(BAD)


def test_seven_good_samples_close_it(opened):
    opened.feed(GOOD, 7)
    assert not opened.passes(BAD)


def test_as_many_bad_samples_as_good_ones_open_it(closed):
    for _ in range(7):
        closed.passes(GOOD)
        closed.feed(BAD, 1)
    assert closed.passes(BAD)


def test_error_is_judged_in_meters(closed):
    lib.outlierFilterLighthouseValidateSweep(closed.state, 1.0, 0.049, closed.now)
    assert closed.state.openingWindowMs == 40
    lib.outlierFilterLighthouseValidateSweep(closed.state, 1.0, 0.05, closed.now)
    assert closed.state.openingWindowMs == 32


def test_a_window_below_zero_opens_in_the_past(opened):
    opened.passes(BAD)
    assert (opened.state.openingTimeMs, opened.state.openingWindowMs) == (1008 - 16, -16)


@given(st.lists(st.tuples(st.floats(width=32), st.floats(width=32), st.integers(0, 2**32 - 1)), max_size=30))
def test_window_stays_between_its_limits(samples):
    gate = Gate()
    for distance, error, now_ms in samples:
        lib.outlierFilterLighthouseValidateSweep(gate.state, distance, error, now_ms)
        assert -16 <= gate.state.openingWindowMs <= 40
        assert gate.state.openingTimeMs == (now_ms + gate.state.openingWindowMs) % 2**32
