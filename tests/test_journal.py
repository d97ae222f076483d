"""The journal keeps every request as it was, in memory and in arrays."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.recording.journal import Journal, Request

scalars = st.one_of(
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(allow_nan=False),
    st.text(max_size=8),
    st.binary(max_size=8),
    st.none(),
)
arguments = st.lists(st.recursive(scalars, lambda inner: st.lists(inner, max_size=4), max_leaves=8), max_size=5)
requests = st.lists(
    st.tuples(st.integers(0, 5), st.sampled_from(["cf_go_to", "param", "packet"]), arguments), max_size=12
)


def written(entries):
    journal = Journal({"seed": 3})
    for tick, (drone, verb, values) in enumerate(entries):
        journal.add(tick // 2, drone, verb, tuple(values))
    return journal


@given(requests)
@settings(max_examples=40)
def test_requests_come_back_with_values_types_and_order(entries):
    journal = written(entries)
    expected = [Request(tick // 2, drone, verb, tuple(values)) for tick, (drone, verb, values) in enumerate(entries)]
    for other in (journal, journal.copy(), Journal.from_arrays(journal.to_arrays())):
        found = list(other)
        assert found == expected
        assert repr(found) == repr(expected)  # 1 == 1.0 == True
        assert len(other) == len(entries)
        assert other.gap is None


def test_a_number_of_numpy_comes_back_as_a_plain_one():
    journal = Journal()
    journal.add(0, 0, "cf_go_to", (np.float32(0.1), np.int16(-3), np.bool_(True), np.float64(0.2)))
    values = next(iter(journal)).arguments
    assert values == (float(np.float32(0.1)), -3, True, 0.2)
    assert [type(value) for value in values] == [float, int, bool, float]


def test_numbers_keep_their_bits():
    journal = Journal()
    for value in (-0.0, math.inf, 5e-324, 0.1):
        journal.add(0, 0, "cf_send_hover", (value, 1.0))
    assert [str(request.arguments[0]) for request in journal] == ["-0.0", "inf", "5e-324", "0.1"]


@pytest.mark.parametrize("order", [(2**60, 7, 2**60), (7, 2**60, 7)])
def test_bytes_behind_numbers_come_back_whatever_came_before(order):
    """Packets are written down without a look at their types, once some like them have come."""
    entries = [(0, "packet", [number, 1, b"bytes" * (number % 3)]) for number in order]
    journal = Journal.from_arrays(written(entries).to_arrays())
    assert [list(request.arguments) for request in journal] == [values for _, _, values in entries]


def test_what_no_file_can_hold_is_a_gap_and_says_so():
    journal = Journal()
    journal.add(1500, 0, "restore", (object(),))
    assert len(journal) == 0
    assert journal.gap == "'restore' at 1.500 s carries a object, which no file can hold"
    assert Journal.from_arrays(journal.to_arrays()).gap == journal.gap


def test_a_copy_goes_on_by_itself():
    journal = Journal()
    journal.add(0, 0, "cf_takeoff", (0.5, 1.0))
    other = journal.copy()
    other.add(1, 0, "cf_takeoff", (0.6, 1.0))
    journal.add(1, 0, "cf_land", (0.0, 1.0))
    assert [request.verb for request in journal] == ["cf_takeoff", "cf_land"]
    assert [request.arguments for request in other] == [(0.5, 1.0), (0.6, 1.0)]


def test_a_setpoint_takes_tens_of_bytes():
    journal = Journal()
    for tick in range(1000):
        journal.add(tick, 0, "cf_send_hover", (0.1, 0.2, 0.0, 0.5))
    arrays = journal.to_arrays()
    assert sum(values.nbytes for values in arrays.values()) < 60_000


@pytest.mark.parametrize(
    ("name", "broken"),
    [
        ("ticks", lambda values: values[::-1].copy()),
        ("ticks", lambda values: values[:-1]),
        ("kinds", lambda values: values + 7),
        ("numbers", lambda values: values[:-1]),
        ("blob", lambda values: values[:-1]),
        ("about", lambda values: np.array(str(values).replace("[fy]", "[f[y]"))),
        ("about", lambda values: np.array("{}")),
    ],
)
def test_broken_arrays_are_refused(name, broken):
    journal = Journal()
    journal.add(0, 0, "packet", (7, [0.5, b"abc"]))
    journal.add(9, 1, "cf_stop", ())
    arrays = journal.to_arrays()
    arrays[name] = broken(arrays[name])
    with pytest.raises((ValueError, KeyError)):
        Journal.from_arrays(arrays)


def test_a_journal_that_was_stopped_stays_empty_and_says_why():
    journal = written([(0, "cf_go_to", [1.0]), (1, "packet", [b"ab"])])
    journal.stop("nobody wanted it")
    for other in (journal, journal.copy(), journal.begin_again()):
        other.add(0, 0, "cf_go_to", (1.0,))
        other.add(0, 0, "packet", (b"abc",))
        other.add_blocks(0, np.array([0, 1], np.int32), "setpoint", b"abcabc", 3)
        assert len(other) == 0
        assert other.gap == "nobody wanted it"
        assert other.recipe == {"seed": 3}
    read = Journal.from_arrays(journal.to_arrays())
    assert (len(read), read.gap) == (0, "nobody wanted it")


def test_a_journal_begins_again_with_its_world():
    journal = written([(0, "cf_go_to", [1.0])]).begin_again()
    journal.add(0, 0, "cf_go_to", (2.0,))
    assert [request.arguments for request in journal] == [(2.0,)]
    assert journal.gap is None
