"""Rounds that the core flies and records alone are those that Python steps through, bit for bit."""

import numpy as np
import pytest

from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission.loader import parse_mission
from crazychoir_fw.simulation import FlightRecorder

DRONES = [{"id": "cf1", "position": [0.0, 0.0]}, {"id": "cf2", "position": [1.0, 0.0]}]
FLIGHT = [{"takeoff": {"height": 0.5, "duration": 1.0}}, {"hover": {"duration": 1.237}}, {"land": {"duration": 1.0}}]
MOTOR = {"motor": {"drones": ["cf2"], "at": 1.333, "motor": 1, "efficiency": 0.0}}
KICK = {"kick": {"drones": ["cf1"], "at": 1.5, "impulse": [0.01, 0.0, 0.0]}}


def mission(faults):
    return parse_mission({"name": "alone", "drones": DRONES, "flight": FLIGHT, "faults": faults})


def same(one, other):
    assert one.log.time.tobytes() == other.log.time.tobytes()
    assert one.log.signals.keys() == other.log.signals.keys()
    for name, samples in one.log.signals.items():
        assert samples.tobytes() == other.log.signals[name].tobytes(), name
    assert one.log.events == other.log.events
    assert one.log.journal.samples == other.log.journal.samples
    assert one.failures == other.failures


@pytest.fixture
def alone(monkeypatch):
    """Counts samples that were taken without Python."""
    counts, run_alone = [], FlightRecorder.run_alone

    def counted(recorder, count):
        taken = run_alone(recorder, count)
        counts.append(taken[0])
        return taken

    monkeypatch.setattr(FlightRecorder, "run_alone", counted)
    return counts


@pytest.mark.parametrize("faults", [[], [MOTOR], [KICK]], ids=["none", "motor", "kick"])
def test_flights_without_an_observer_are_those_with_one(faults, alone):
    watched = fly(mission(faults), observe=lambda *_: None)
    assert not alone
    unseen = fly(mission(faults))
    assert sum(alone) > 100
    same(watched, unseen)
    assert bool(unseen.failures) == (faults == [MOTOR])


def test_an_appointment_is_kept_at_its_tick(alone):
    from crazychoir_fw.flight.backends import build_world

    world = build_world(mission([]))
    world.wait_until_ready()
    begun, kept = world.tick, []
    world.agenda.at(begun + 35, lambda: kept.append(world.tick - begun))
    world.agenda.every(50, lambda: kept.append(world.tick - begun), phase=begun)
    recorder = FlightRecorder(world)
    recorder.sample()
    while world.tick < begun + 120:
        if not recorder.run_alone((begun + 120 - world.tick) // 10)[0]:
            world.step(10)
            recorder.sample()
    assert kept == [35, 50, 100]
    assert np.diff(recorder.times) == pytest.approx(0.01)
    assert sum(alone) >= 6
