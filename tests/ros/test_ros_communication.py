"""What neighbors of a flight as processes have heard of each other: as in one process, and told in summary.json."""

import json

import pytest
from ros_flights import PATIENCE, Flight

from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import load_mission

MISSION = """
name: near
backend: integrator
seed: 4
drones:
  - {id: agent_0, position: [0.0, 0.0]}
  - {id: agent_1, position: [0.8, 0.0]}
  - {id: agent_2, position: [1.5, 0.0]}
layers:
  communication: {graph: {within_distance: 0.9}, loss: 0.1, deadline_s: 0.03}
  guidance:
    class: Containment
    leaders: [agent_0, agent_2]
    options: {k: 0.6, heights: [0.4, 0.4, 1.2]}
  planning: {class: Spline}
  control: {gains: mujoco}
flight:
  - takeoff: {duration: 1.5}
  - start: {duration: 1.5}
  - land: {duration: 1.0}
criteria: {landed: false}
"""
"""agent_2 leaves the others while it climbs."""

WARM_UP_ROUNDS = 10


def test_neighbors_by_distance_and_losses_are_those_of_one_process(tmp_path):
    flight = Flight(tmp_path, MISSION, "--processes", "per-drone")
    try:
        flight.begin()
        assert flight.process.wait(PATIENCE) == 0, flight.log.read_text()[-3000:]
    finally:
        flight.close()
    talk = json.loads((flight.out / "summary.json").read_text())["communication"]
    alone = fly(load_mission(flight.file), visuals=False).summary["communication"]
    assert list(talk) == list(alone) == ["total", "agent_0", "agent_1", "agent_2"]
    for name, counts in talk.items():
        expected = alone[name]
        # an agent that loses a message waits, and from then on rounds alternate in another order
        for key in ("sent", "rounds", "received"):
            assert counts[key] == pytest.approx(expected[key], rel=0.1, abs=2 * WARM_UP_ROUNDS), (name, key)
        assert counts["lost"] > 0
    # an agent that flies high receives no messages then
    assert talk["agent_2"]["received"] < 0.5 * talk["agent_1"]["received"]
    assert talk["total"]["sent"] == sum(talk[f"agent_{i}"]["sent"] for i in range(3))
    took = talk["agent_1"]["round_ms"]
    assert 0.0 < took["mean"] <= took["max"]
