"""Missions whose guidance works for a table: what is refused, and a short flight."""

import pytest
from flown_layers import hover, mission, within

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.engine import fly


def tasks(**changes):
    layers = {
        "rate": 50,
        "odometry": "truth",
        "communication": {"graph": "complete"},
        "guidance": {"class": "TaskGuidance", "options": {"max_iterations": 6, "speed": 1.0}},
        "tasks": {"generations": 1, "low": [-1, -1], "high": [2, 1], "probability": 1.0},
    }
    flight = [{"takeoff": {"duration": 2}}, {"start": {"duration": 5}}, {"land": {"duration": 2}}]
    return {**hover(2), "layers": layers, "flight": flight, **changes}


def test_a_short_flight_of_tasks_is_judged_and_told():
    result = fly(mission(tasks(criteria={"tasks_completed": 2, "assignment_optimal": True})))
    assert result.success, result.failures
    assert {interval.drone for interval in result.timeline.intervals} == {0, 1}
    assert {mark.label for mark in result.timeline.marks} == {"0", "1"}


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("layers.tasks", None, "layers.tasks is missing"),
        ("layers.guidance.class", "SimpleGuidance", "layers.tasks is for the class TaskGuidance"),
        ("layers.tasks.low", [3, 3], "must be below high"),
        ("layers.communication.graph", (), "graph is missing"),
        ("criteria.routes_gap", 0.1, "criteria.routes_gap needs layers.delivery"),
    ],
)
def test_what_does_not_go_together(path, value, said):
    with pytest.raises(MissionError, match=said):
        mission(within(tasks(), path, value))
