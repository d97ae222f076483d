"""Distances of signals: exact in ulps, exact in time, explicit about what is no number."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy

from crazychoir_fw.parity.deviation import POINTS, UNMATCHED_ULPS, Verdict, join, measure, overall, trace, ulps_apart
from crazychoir_fw.parity.tolerances import Tolerance

STRICT = Tolerance("strict", ("*",), "none")
LOOSE = Tolerance("loose", ("*",), "for tests", absolute=0.5, unit="m", ulps=4)
floats = st.floats(width=32, allow_nan=False, allow_infinity=False)
anything = st.floats(width=32)


def steps(value, count):
    """Return the float that many steps above a float."""
    value = np.float32(value)
    for _ in range(count):
        value = np.nextafter(value, np.float32(np.inf))
    return value


@given(floats.filter(lambda x: abs(x) < 3e38), st.integers(0, 50))
def test_ulps_count_the_steps_between_two_floats(value, count):
    other = steps(value, count)
    assert ulps_apart(value, other)[0] == count
    assert ulps_apart(other, value)[0] == count


@given(anything, anything)
def test_ulps_are_zero_for_equal_numbers_alone(a, b):
    a, b = np.float32(a), np.float32(b)
    is_same = a == b or (np.isnan(a) and np.isnan(b))
    assert (ulps_apart(a, b)[0] == 0) == is_same


@given(floats, floats, floats)
def test_ulps_add_up_along_the_line(a, b, c):
    low, middle, high = sorted([a, b, c])
    assert ulps_apart(low, high)[0] == ulps_apart(low, middle)[0] + ulps_apart(middle, high)[0]


@given(anything.filter(lambda x: not math.isnan(x)))
def test_a_number_is_farther_from_nan_than_from_any_number(value):
    assert ulps_apart(value, np.nan)[0] == UNMATCHED_ULPS
    assert ulps_apart(np.finfo(np.float32).max, np.finfo(np.float32).min)[0] < UNMATCHED_ULPS


def test_zeros_of_both_signs_are_one_number():
    assert ulps_apart(0.0, -0.0)[0] == 0
    assert ulps_apart(np.float32(1e-45), np.float32(-1e-45))[0] == 2


def run(reference, candidate, tolerance=STRICT, ticks=None):
    reference, candidate = np.asarray(reference, np.float32), np.asarray(candidate, np.float32)
    ticks = np.arange(len(reference)) if ticks is None else ticks
    return measure("signal", reference, candidate, ticks, tolerance)


@given(st.integers(0, 99), st.integers(1, 100), floats.filter(lambda x: abs(x) < 1e37))
def test_one_changed_sample_is_found_with_its_tick_and_size(index, count, value):
    reference = np.full(100, value, np.float32)
    candidate = reference.copy()
    candidate[index] = steps(value, count)
    found = run(reference, candidate, ticks=np.arange(1000, 1100))
    assert (found.deviating, found.first_tick, found.worst_tick) == (1, 1000 + index, 1000 + index)
    assert found.max_ulps == count
    assert found.max_absolute == float(candidate[index]) - float(reference[index])
    assert found.rms == pytest.approx(found.max_absolute / 10.0)
    assert (found.worst_reference, found.worst_candidate) == (reference[index], candidate[index])
    assert found.verdict is Verdict.DIFFERENT


signals = st_numpy.arrays(np.float32, st.integers(1, 40), elements=anything)


@given(st.data(), signals)
def test_stretches_joined_are_the_whole(data, reference):
    candidate = data.draw(st_numpy.arrays(np.float32, reference.shape, elements=st.sampled_from([*reference, 0.0])))
    cut = data.draw(st.integers(0, len(reference)))
    ticks = np.arange(len(reference))
    parts = [
        measure("signal", reference[part], candidate[part], ticks[part], LOOSE)
        for part in (slice(cut), slice(cut, None))
    ]
    together, whole = join(*parts), run(reference, candidate, LOOSE)
    assert together.sum_of_squares == pytest.approx(whole.sum_of_squares, rel=1e-12)
    for name in ("samples", "deviating", "beyond", "unmatched", "max_ulps", "max_absolute", "first_tick", "share"):
        assert getattr(together, name) == getattr(whole, name), name
    assert (together.first_beyond_tick, together.worst_tick) == (whole.first_beyond_tick, whole.worst_tick)


@given(signals)
def test_a_signal_is_identical_to_itself_whatever_is_in_it(values):
    found = run(values, values.copy())
    assert found.verdict is Verdict.IDENTICAL
    assert found.first_tick is None


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_no_tolerance_covers_what_is_no_number(bad):
    huge = Tolerance("huge", ("*",), "for tests", absolute=1e30, ulps=2**40, relative=1e9)
    found = run([1.0, 2.0, 3.0], [1.0, bad, 3.0], huge)
    assert found.verdict is Verdict.DIFFERENT
    assert (found.unmatched, found.first_tick, found.first_beyond_tick) == (1, 1, 1)
    assert found.max_absolute == np.inf
    assert found.rms == 0.0


def test_equal_infinities_and_nan_are_identical():
    values = [np.inf, -np.inf, np.nan]
    assert run(values, values).verdict is Verdict.IDENTICAL
    assert run([np.inf], [-np.inf], LOOSE).verdict is Verdict.DIFFERENT


def test_near_enough_by_one_of_the_measures_is_within_tolerance():
    assert run([1.0], [1.4], LOOSE).verdict is Verdict.EQUAL
    assert run([1e9], [steps(1e9, 4)], LOOSE).verdict is Verdict.EQUAL
    assert run([1e9], [steps(1e9, 5)], LOOSE).verdict is Verdict.DIFFERENT
    relative = Tolerance("relative", ("*",), "for tests", relative=0.01)
    assert run([1.0, 100.0], [1.9, 100.0], relative).verdict is Verdict.EQUAL
    assert run([1.0, 100.0], [2.1, 100.0], relative).verdict is Verdict.DIFFERENT


def test_first_tick_beyond_tolerance_is_another_than_the_first():
    found = run([0, 0, 0, 0], [0, 0.1, 0.6, 0.9], LOOSE)
    assert (found.first_tick, found.first_beyond_tick, found.worst_tick, found.beyond) == (1, 2, 3, 2)
    assert found.share == pytest.approx(1.8)


def test_angles_on_both_sides_of_the_wrap_are_neighbors():
    angle = Tolerance("angle", ("*",), "for tests", absolute=0.5, unit="deg", turn=360.0)
    found = run([179.9, -180.0], [-179.9, 180.0], angle)
    assert found.verdict is Verdict.EQUAL
    assert found.max_absolute == pytest.approx(0.2, abs=1e-4)


def test_whole_numbers_have_no_ulps():
    values = np.array([1, 2, 65535], np.uint16)
    found = measure("count", values, np.array([1, 3, 65535], np.uint16), np.arange(3), STRICT)
    assert (found.max_ulps, found.max_absolute, found.first_tick) == (None, 1.0, 1)


def test_signals_of_other_lengths_are_refused():
    with pytest.raises(ValueError, match="signal"):
        run([1.0, 2.0], [1.0])


def test_what_is_not_judged_does_not_make_the_whole_different():
    shown = Tolerance("shown", ("*",), "for tests", is_judged=False)
    assert run([1.0], [2.0], shown).verdict is Verdict.NOT_JUDGED
    assert overall([Verdict.NOT_JUDGED, Verdict.IDENTICAL]) is Verdict.EQUAL
    assert overall([Verdict.MISSING, Verdict.IDENTICAL]) is Verdict.IDENTICAL
    assert overall([Verdict.EQUAL, Verdict.DIFFERENT]) is Verdict.DIFFERENT
    assert overall([]) is Verdict.IDENTICAL


def test_json_holds_only_numbers_that_json_knows():
    text = json.dumps(run([1.0, 2.0], [1.0, np.nan], LOOSE).as_json(), allow_nan=False)
    assert json.loads(text)["max_absolute"] is None
    assert json.loads(text)["worst_candidate"] == "nan"


@given(st.integers(1, 3 * POINTS), st.data())
def test_a_thinned_trace_loses_no_deviation(length, data):
    reference = np.zeros(length, np.float32)
    candidate = reference.copy()
    at = data.draw(st.integers(0, length - 1))
    candidate[at] = data.draw(st.sampled_from([0.25, np.nan, np.inf]))
    thinned = trace(reference, candidate, np.arange(length))
    expected = 0.25 if np.isfinite(candidate[at]) else np.inf
    assert thinned.deviation.max() == expected
    assert len(thinned.ticks) == min(length, POINTS)
