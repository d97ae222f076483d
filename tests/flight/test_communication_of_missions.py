"""Graphs that change and messages that get lost, as mission files say."""

import pytest
from flown_layers import formation, mission, within

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.mission.communicators import graph_of, schedule_of


def talking(**communication):
    return within(formation(), "layers.communication", {"graph": "complete", **communication})


def test_graphs_by_schedule():
    chosen = {"schedule": [{"at": 0, "graph": [["a", "b"]]}, {"at": 5.0, "graph": "ring"}], "period": 10.0}
    flown = mission(talking(graph={**chosen, "schedule": [{"at": 0, "graph": "complete"}, chosen["schedule"][1]]}))
    schedule = schedule_of(flown, begin=1.0)
    assert len(graph_of(flown).edges) == 12
    assert schedule.neighbors_at(0, 1.5, 0)[0] == (1, 2, 3)
    assert schedule.neighbors_at(0, 6.5, 0)[0] == (1, 3)
    assert schedule.neighbors_at(0, 11.5, 0)[0] == (1, 2, 3)


def test_graphs_by_distance_need_positions():
    flown = mission(talking(graph={"within_distance": 1.05}))
    with pytest.raises(MissionError, match="within_distance needs everybody's position"):
        schedule_of(flown)
    experiment = make_experiment(flown)
    assert experiment.agents[0].guidance.schedule.neighbors_at(0, 0.0, 0)[0] == (1,)


def test_a_mission_says_how_long_neighbors_may_be_silent():
    flown = mission(talking(graph="complete", silence_s=1.5, deadline_s=0.02))
    guidance = make_experiment(flown).agents[0].guidance
    assert (guidance.silence, guidance.deadline) == (1.5, 0.02)


def test_a_formation_bears_losses_and_edges_that_come_and_go():
    data = talking(
        graph={"random_edges": {"probability": 0.8, "rounds": 5}}, loss=0.2, duplication=0.1, differentiated_topics=True
    )
    flown = mission({**data, "criteria": {"bearing_error_deg": 3.0}})
    first, second = fly(flown), fly(flown)
    assert first.success, first.failures
    total = first.summary["communication"]["total"]
    assert total["lost"] > 0.1 * total["sent"]
    assert first.summary["communication"] == second.summary["communication"]
    assert (first.log.signals["sim.x"] == second.log.signals["sim.x"]).all()


@pytest.mark.parametrize(
    ("communication", "says"),
    [
        ({"loss": 1.5}, "communication.loss is 1.5"),
        ({"graph": {"within_distance": 1.0, "random": {}}}, "a graph by one rule"),
        ({"graph": {"schedule": [{"at": 1}, {"at": 0}]}}, "in order of at"),
        ({"graph": {"within_distance": 1.0, "period": 3}}, "a period beyond"),
        ({"graph": {"of": {"within_distance": 1.0}, "within_distance": 1.0}}, "graphs that do not change"),
    ],
)
def test_communication_that_cannot_be_is_refused(communication, says):
    with pytest.raises(MissionError, match=says):
        mission(talking(**communication))
