"""Appointments at simulated times."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.event_scheduler import EventScheduler


def walk(agenda, end, now=0):
    """Step from appointment to appointment, as a world does."""
    agenda.keep(now)
    while now < end:
        now = agenda.next_stop(end)
        agenda.keep(now)


def test_appointments_are_kept_at_their_ticks_in_order_of_coming():
    agenda, kept = EventScheduler(), []
    agenda.every(4, lambda: kept.append("every 4"))
    agenda.at(4, lambda: kept.append("first at 4"))
    agenda.at(4, lambda: kept.append("second at 4"))
    agenda.at(0, lambda: kept.append("at once"))
    agenda.at(2, lambda: kept.append("at 2"))
    walk(agenda, 8)
    assert kept == ["at once", "at 2", "first at 4", "second at 4", "every 4", "every 4"]


@given(st.lists(st.integers(0, 50), max_size=20), st.integers(1, 12), st.integers(0, 11), st.integers(0, 49))
def test_going_back_in_time_meets_the_same_appointments_again(ticks, period, phase, back):
    agenda, kept, now = EventScheduler(), [], [0]
    for number, tick in enumerate(ticks):
        agenda.at(tick, lambda number=number: kept.append((now[0], number)))
    agenda.every(period, lambda: kept.append((now[0], "periodic")), phase)

    def fly(start):
        kept.clear()
        now[0] = start
        agenda.keep(start)
        while now[0] < 50:
            now[0] = agenda.next_stop(50)
            agenda.keep(now[0])
        return list(kept)

    whole = fly(0)
    agenda.seek(back)
    assert fly(back) == [entry for entry in whole if entry[0] > back]


def test_what_falls_between_two_steps_is_kept_once_after_the_later_one():
    agenda, kept, now = EventScheduler(), [], 0
    agenda.every(10, lambda: kept.append(now))
    for now in range(0, 61, 4):
        agenda.keep(now)
    assert kept == [12, 20, 32, 40, 52, 60]


def test_the_past_and_empty_periods_are_refused():
    agenda = EventScheduler()
    walk(agenda, 10)
    with pytest.raises(RangeError, match="tick 9: allowed: the present tick 10"):
        agenda.at(9, print)
    with pytest.raises(RangeError, match="period of 0 ticks"):
        agenda.every(0, print)


def test_a_canceled_appointment_is_not_kept():
    agenda, kept = EventScheduler(), []
    cancel = agenda.every(2, lambda: kept.append(1))
    walk(agenda, 5)
    cancel()
    walk(agenda, 10, now=5)
    assert kept == [1, 1]


def test_a_world_stops_for_its_appointments_and_flies_the_same_bits():
    seen = []
    plain, busy = (World([DroneConfig("cf1")], seed=4) for _ in range(2))
    busy.agenda.every(7, lambda: seen.append(busy.tick))
    busy.agenda.at(50, lambda: busy.note("test", "cf1", answer=42))
    for world in (plain, busy):
        world.step(100)
    assert seen == list(range(7, 101, 7))
    assert plain.snapshot().tobytes() == busy.snapshot().tobytes()
    (event,) = busy.events
    assert (event.time, event.kind, event.drone, event.details) == (pytest.approx(0.05), "test", "cf1", {"answer": 42})


def test_events_of_a_future_that_was_taken_back_are_forgotten():
    world = World([DroneConfig("cf1")])
    world.agenda.at(10, lambda: world.note("early"))
    world.agenda.at(30, lambda: world.note("late"))
    world.step(20)
    here = world.snapshot()
    world.step(20)
    assert [event.kind for event in world.events] == ["early", "late"]
    world.restore(here)
    assert [event.kind for event in world.events] == ["early"]
    world.step(20)
    assert [event.kind for event in world.events] == ["early", "late"]
