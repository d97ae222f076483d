"""The pace of a served world, the clock that it goes by, and budgets of packets."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.drone_radio import TokenBucket
from crazychoir_fw.crtp.pacing import MAX_LAG_S, MAX_SLICE, Clock, TickPacer


def advance(pace, until, cost_per_tick=0.0, dt=0.0005):
    """Run a simulation whose ticks take some time on the wall; returns time and tick at the end."""
    now, tick = 0.0, 0
    pace.begin(now, tick)
    while now < until:
        due = pace.due(now, tick)
        tick += due
        now += due * cost_per_tick if due else max(dt, pace.wait_s(now, tick))
    pace.due(now, tick)
    return now, tick


@pytest.mark.parametrize("speed", [0.1, 0.5, 1.0, 3.0, 20.0])
def test_it_keeps_the_speed(speed):
    pace = TickPacer(speed)
    now, tick = advance(pace, 5.0, cost_per_tick=1e-6)
    assert tick == pytest.approx(now * speed * 1000, abs=2 * MAX_SLICE)
    assert pace.real_time_factor == pytest.approx(speed, rel=0.01)
    assert pace.recent_real_time_factor == pytest.approx(speed, rel=0.05)
    assert pace.resyncs == 0


@pytest.mark.parametrize("ticks_per_step", [1, 2, 4, 20])
def test_it_advances_by_whole_steps(ticks_per_step):
    pace = TickPacer(1.0, ticks_per_step)
    pace.begin(0.0, 0)
    for now in (0.0, 0.001, 0.0055, 0.021, 0.11):
        assert pace.due(now, 0) % ticks_per_step == 0
    assert pace.due(0.11, 0) > 0


def test_a_slow_world_gives_up_what_it_cannot_catch_up():
    pace = TickPacer(1.0)
    now, tick = advance(pace, 5.0, cost_per_tick=0.002)
    assert tick == pytest.approx(now * 500, abs=MAX_SLICE)
    assert pace.resyncs > 0
    assert pace.dropped_lag_s == pytest.approx(now / 2, abs=2 * MAX_LAG_S)
    assert MAX_LAG_S < pace.worst_lag_s < 2 * MAX_LAG_S


def test_a_short_stall_is_caught_up():
    pace = TickPacer(1.0)
    pace.begin(0.0, 0)
    tick = 0
    while due := pace.due(0.2, tick):
        assert due <= MAX_SLICE
        tick += due
    assert tick == pytest.approx(200, abs=MAX_SLICE)
    assert pace.worst_lag_s == pytest.approx(0.2)
    assert pace.resyncs == 0


def test_a_pause_is_no_lag():
    pace = TickPacer(1.0)
    pace.begin(0.0, 0)
    pace.begin(100.0, 0)
    assert pace.due(100.001, 0) == 0
    assert pace.worst_lag_s < 0.01
    assert pace.wall_seconds == pytest.approx(0.001)


@pytest.mark.parametrize("speed", [None, 0.0])
def test_as_fast_as_possible(speed):
    pace = TickPacer(speed)
    pace.begin(0.0, 0)
    assert pace.due(0.0, 0) == MAX_SLICE
    assert pace.wait_s(0.0, 0) == 0.0


@pytest.mark.parametrize("speed", [-0.1, 1000.1, math.nan, math.inf])
def test_speeds_that_are_none(speed):
    with pytest.raises(RangeError, match="speed is .* allowed: 0 to 1000"):
        TickPacer(speed)


@given(st.lists(st.tuples(st.booleans(), st.floats(-10, 10), st.floats(0, 10)), max_size=30))
def test_a_clock_never_goes_back(events):
    source = [5.0]
    clock = Clock(lambda: source[0])
    readings = [clock()]
    for is_new_source, change, rate in events:
        source[0] += change
        if is_new_source:
            clock.follow(lambda: source[0], rate)
        readings.append(clock())
    assert readings == sorted(readings)


def test_a_clock_goes_on_where_it_was():
    source = [5.0]
    clock = Clock(lambda: source[0])
    source[0] = 7.0
    clock.follow(lambda: 100.0 + source[0], 3.0)
    assert clock() == pytest.approx(2.0)
    source[0] = 8.0
    assert clock() == pytest.approx(5.0)


@given(st.lists(st.floats(0.0, 0.3), min_size=1, max_size=200))
def test_a_bucket_is_never_exceeded(gaps):
    bucket = TokenBucket(rate=10.0, burst=5.0)
    now, passed = 0.0, 0
    for gap in gaps:
        now += gap
        passed += bucket.take(now)
    assert passed <= 5 + now * 10 + 1e-6


def test_a_bucket_lets_pass_what_it_may():
    bucket = TokenBucket(rate=10.0, burst=5.0)
    assert [bucket.take(100.0) for _ in range(6)] == [True] * 5 + [False]
    assert all(bucket.take(100.11 + 0.1001 * k) for k in range(50))
