"""Missions fail when drones hit each other or obstacles too fast."""

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import parse_mission


def mission(**changes):
    """Two drones that fly into each other, 0.6 m in 2 s each."""
    legs = [
        {"go_to": {"drones": ["a"], "offset": [0.6, 0, 0], "duration": 2.0}},
        {"go_to": {"drones": ["b"], "offset": [-0.6, 0, 0], "duration": 2.0}},
    ]
    flight = [{"takeoff": {"height": 0.5, "duration": 1.5}}, {"together": legs}, {"land": {"duration": 1.5}}]
    drones = [{"id": "a", "position": [-0.4, 0]}, {"id": "b", "position": [0.4, 0]}]
    return parse_mission({"name": "crossing", "drones": drones, "flight": flight, **changes})


def test_two_drones_that_collide_fail_the_mission():
    result = fly(mission())
    assert not result.success
    assert result.failures[0].startswith("a: hit b with ")
    assert result.failures[0].endswith("tolerance 0.2 m/s")
    first = result.summary["collisions"][0]
    assert (first["drone"], first["other"], first["what"]) == ("a", "b", "drone")
    assert first["speed"] > 0.2


def test_a_mission_may_forgive_collisions():
    result = fly(mission(tolerance={"collision_speed": 50.0, "endpoint": 10.0, "waypoint": 10.0}))
    assert result.summary["collisions"]
    assert not any("hit" in failure for failure in result.failures)


def test_a_flight_without_collisions_lists_none():
    drones = [{"id": "a", "position": [0, 0]}]
    result = fly(mission(drones=drones, flight=[{"takeoff": {"height": 0.3, "duration": 1.0}}, {"land": {}}]))
    assert result.success
    assert result.summary["collisions"] == []


@pytest.mark.parametrize("decks", [["multiranger"], ["zranger", "multiranger"], []])
def test_decks_of_a_mission_are_those_of_the_drone(decks):
    (drone,) = mission(drones=[{"id": "a", "position": [0, 0], "decks": decks}], flight=["takeoff"]).fleet
    assert list(drone.decks) == decks


@pytest.mark.parametrize("decks", ["zranger", ["lidar"], [1], {"zranger": 1}])
def test_unknown_decks_are_refused(decks):
    with pytest.raises(MissionError, match=r"decks is .* must be a list of multiranger, zranger"):
        mission(drones=[{"id": "a", "position": [0, 0], "decks": decks}], flight=["takeoff"])
