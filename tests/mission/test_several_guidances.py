"""Several kinds of guidance in one mission: the layers of each drone, and missions that are refused."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight import agents
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.guidance import BearingFormation, CFGuidance, GoToGuidance, Graph
from crazychoir_fw.mission.loader import parse_mission

GOALS = {"class": "GoToGuidance", "drones": ["d"], "goals": {"d": [[2, 2.0, 1.0, 0.5]]}}
FORMATION = {
    "class": "BearingFormation",
    "drones": ["c", "a", "b"],
    "leaders": ["a", "b"],
    "formation": [[0.0, 1.0], [-0.5, 0.0], [0.5, 0.0]],
    "communication": {"graph": "complete"},
}
PLACES = {"a": [-0.5, 0.0], "b": [0.5, 0.0], "c": [0.1, 0.9], "d": [2.0, 0.0]}


def mission(*guidance, **more):
    return parse_mission(
        {
            "name": "several",
            "backend": "integrator",
            "drones": [{"id": name, "position": place} for name, place in PLACES.items()],
            "layers": {
                "odometry": "truth",
                "guidance": list(guidance),
                "planning": {"class": "Spline"},
                "control": {"class": "HierarchicalController", "gains": "mujoco"},
                **more,
            },
            "flight": [{"takeoff": {"duration": 2.0}}, {"start": {"duration": 3.0}}, {"land": {"duration": 2.0}}],
        }
    )


def test_each_drone_has_the_guidance_of_its_entry():
    both = mission(FORMATION, GOALS)
    assert [agents.guidance_class(both, i) for i in range(4)] == [BearingFormation] * 3 + [GoToGuidance]
    assert both.layers.guidance_of("d").kind == "GoToGuidance"
    assert both.layers.guidance is both.layers.guidances[0]
    assert [agents.leads(both, i) for i in range(4)] == [True, True, False, False]
    assert agents.graph_of(both).edges == Graph.undirected(4, [(0, 1), (0, 2), (1, 2)]).edges
    # places come in the order of the entry, rows are numbers of drones
    np.testing.assert_allclose(agents.formation_of(both, 0)[:3, 0], [-0.5, 0.5, 0.0])


def test_several_kinds_of_guidance_fly_together():
    result = fly(mission(FORMATION, GOALS))
    assert result.summary["success"], result.summary["failures"]
    assert {event["kind"] for event in result.summary["events"]} == {"takeoff", "start", "land", "landed"}
    np.testing.assert_allclose(result.judge.final_positions[3, :2], [2.0, 1.0], atol=0.1)


def test_an_entry_brings_its_own_planning_and_control():
    slow = {**GOALS, "planning": {"class": "SplinePosition"}, "control": {"class": "VelocityController"}}
    both = mission(FORMATION, slow)
    assert [agents.what_it_follows(both, i) for i in range(4)] == ["fullstate", "fullstate", "acceleration", "position"]
    groups = agents.make_groups(both, [0.03] * 4)
    assert [(list(group.indices), group.kind) for group in groups] == [([0, 1, 2], "fpqr"), ([3], "vel")]
    assert both.layers.commands == ("fpqr", "vel")
    assert mission(FORMATION, {**slow, "planning": None, "control": None}).layers.commands == ("fpqr", "xyz")


@pytest.mark.parametrize(
    ("guidance", "sentence"),
    [
        ([FORMATION], "layers.guidance decides nothing for 'd'"),
        (
            [FORMATION, {**GOALS, "drones": ["d", "a"]}],
            r"layers.guidance\[1\].drones names 'a', but layers.guidance\[0\]",
        ),
        ([FORMATION, {**GOALS, "drones": ["e"]}], r"layers.guidance\[1\].drones names 'e'"),
        ([FORMATION, {"class": "SimpleGuidance"}], r"layers.guidance\[1\].drones is missing"),
        ([FORMATION, {**GOALS, "goals": {"a": [[1, 0, 0, 1]]}}], r"layers.guidance\[1\].goals names 'a'"),
        ([{**FORMATION, "leaders": ["d"]}, GOALS], r"layers.guidance\[0\].leaders names 'd'"),
        ([FORMATION, {**GOALS, "hieght": 1}], r"layers.guidance\[1\] has no key 'hieght'"),
        ([FORMATION, {**GOALS, "options": {"radius": 1}}], r"layers.guidance\[1\].options has no key 'radius'"),
        ([FORMATION, {**GOALS, "control": None}], r"layers.guidance\[1\].control is missing"),
        ([], "layers.guidance is .*a list of at least 1"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_place(guidance, sentence):
    with pytest.raises(MissionError, match=sentence):
        agents.make_agents(mission(*guidance), lambda: 0.0)


def test_a_formation_that_talks_to_strangers_is_refused():
    with pytest.raises(MissionError, match="only one of them is in this formation"):
        mission(FORMATION, GOALS, communication={"graph": [["a", "d"]]})


def test_a_mapping_names_no_drones():
    with pytest.raises(MissionError, match="layers.guidance.drones is for a list"):
        parse_mission(
            {
                "name": "one",
                "drones": [{"id": "a", "position": [0, 0]}],
                "layers": {"guidance": {"class": "SimpleGuidance", "drones": ["a"]}},
                "flight": ["land"],
            }
        )


class Watcher(CFGuidance):
    """Record the poses of other drones that it receives."""

    watched = (3,)

    def __init__(self, **options):
        super().__init__(**options)
        self.seen = []

    def see(self, number, pose):
        self.seen.append((number, pose))

    def step(self, now):
        assert self.seen[-1][1].time == now  # before it decides
        return super().step(now)


def test_who_watches_is_told_where_others_are_each_round():
    experiment = make_experiment(mission({**GOALS, "drones": list(PLACES), "goals": {}}))
    watcher = Watcher(agent_id=1, init_pos=[0.5, 0.0])
    agent = experiment.agents[1]
    agent.guidance = watcher
    experiment = type(experiment)(experiment.backend, experiment.agents, experiment.groups)
    experiment.takeoff()
    experiment.run(0.1)
    assert [number for number, _ in watcher.seen] == [3] * 10
    np.testing.assert_allclose(watcher.seen[-1][1].position[:2], [2.0, 0.0], atol=1e-6)
    assert agent.failure is None
