"""Containment: where followers come to rest, how fast, over graphs that change, and the loss of an agent."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from integrators import Integrators

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import (
    Containment,
    Graph,
    InProcessTransport,
    TimeVaryingCommunicator,
    TimeVaryingContainment,
)
from crazychoir_fw.guidance.containment import equilibrium
from crazychoir_fw.guidance.hull import distance_from_hull

LEADERS = (0, 1, 2, 3)
PLACES = np.array([(1, 1, 0.6), (-1, 1, 1.4), (-1, -1, 0.6), (1, -1, 1.4)], float)
STARTS = np.vstack([PLACES, [(2, 0.2, 1), (0.3, 1.9, 1), (-2, -0.3, 1), (-0.1, -2.1, 1)]])
GRAPH = Graph.undirected(
    8, [(0, 4), (3, 4), (0, 5), (1, 5), (1, 6), (2, 6), (2, 7), (3, 7), (4, 5), (5, 6), (6, 7), (7, 4)]
)


def swarm(cls=Containment, graph=GRAPH, **options):
    made = Integrators(cls, graph, STARTS, leaders=LEADERS, max_speed=np.inf, **options)
    made.press("start")
    return made


def test_followers_rest_at_the_equilibrium_which_lies_in_the_hull():
    made = swarm(k=0.8).run(8.0)
    rest = equilibrium(GRAPH, LEADERS, STARTS)
    np.testing.assert_allclose(made.position, rest, atol=5e-3)
    np.testing.assert_allclose(rest[4], (0.5, 0.0, 1.0), atol=1e-9)
    assert all(distance_from_hull(place, PLACES) < 1e-9 for place in rest[4:])


def test_errors_fall_as_the_laplacian_says():
    made = swarm(k=0.1)
    rest = equilibrium(GRAPH, LEADERS, STARTS)
    hears = GRAPH.adjacency.T
    rates, modes = np.linalg.eigh((np.diag(hears.sum(axis=1)) - hears)[4:, 4:])
    before = (made.position - rest)[4:]
    made.run(6.0)
    expected = modes @ (np.exp(-0.1 * rates * 6.0)[:, None] * (modes.T @ before))
    np.testing.assert_allclose((made.position - rest)[4:], expected, atol=0.03)


@settings(max_examples=2)
@given(seed=st.integers(0, 10_000))
def test_random_edges_lead_near_the_same_place(seed):
    made = _time_varying(seed).run(12.0)
    assert np.linalg.norm(made.position - equilibrium(GRAPH, LEADERS, STARTS), axis=1).max() < 0.25
    assert all(distance_from_hull(place, PLACES) < 0.1 for place in made.position[4:])


def _time_varying(seed, **options):
    class Drawn(TimeVaryingContainment):
        def __init__(self, *arguments, **settings):
            super().__init__(*arguments, graph=GRAPH, seed=seed, k=0.3, **settings)

    return swarm(Drawn, **options)


def test_both_ends_of_an_edge_agree_and_edges_are_there_with_their_probability():
    made = _time_varying(1)
    there = 0
    for label in range(0, 400, 2):
        heard = {i: set(made.agents[i].schedule.neighbors_at(i, 0.0, label)[0]) for i in range(8)}
        assert all(i in heard[j] for i in range(8) for j in heard[i])
        there += sum(map(len, heard.values()))
    assert there / 2 / 12 / 200 == pytest.approx(0.8, abs=0.04)


def test_without_a_follower_the_others_rest_where_the_smaller_graph_wants():
    made = swarm(k=0.8).run(1.0)
    made.kill(5)
    made.run(10.0)
    smaller = GRAPH.without([5])
    places = equilibrium(Graph(8, (*smaller.edges, (0, 5))), LEADERS, STARTS)
    np.testing.assert_allclose(made.position[[4, 6, 7]], places[[4, 6, 7]], atol=5e-3)


def test_without_a_leader_the_others_are_enough():
    made = swarm(k=0.8).run(1.0)
    made.kill(0)
    made.run(10.0)
    assert all(distance_from_hull(place, PLACES[1:]) < 5e-3 for place in made.position[4:])


def test_leaders_ask_for_trajectories_and_followers_climb_alone():
    made = Integrators(Containment, GRAPH, STARTS * (1, 1, 0), leaders=LEADERS, heights=[0.5] * 4 + [0.8] * 4)
    made.press("takeoff")
    outputs = made.agents[0].step(0.0)
    np.testing.assert_allclose(outputs.trajectory[0].position, (1.0, 1.0, 0.5))
    made.run(6.0)
    np.testing.assert_allclose(made.position[4:, 2], 0.8)


def test_equilibrium_needs_a_leader_for_everybody():
    with pytest.raises(RangeError, match="no way leads from a leader"):
        equilibrium(Graph.undirected(3, [(0, 1)]), [0], np.zeros((3, 3)))


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), corners=st.integers(1, 8))
def test_distance_from_a_hull(seed, corners):
    dice = np.random.default_rng(seed)
    hull = dice.uniform(-1.0, 1.0, (corners, 3)) * ((1, 1, 0) if seed % 3 == 0 else (1, 1, 1))
    weights = dice.dirichlet(np.ones(corners))
    assert distance_from_hull(weights @ hull, hull) < 1e-6
    far = dice.standard_normal(3) * 3.0
    distance = distance_from_hull(far, hull)
    # a lower bound from the nearest supporting plane, an upper one from samples
    assert distance <= np.linalg.norm(hull - far, axis=1).min() + 1e-9
    samples = dice.dirichlet(np.ones(corners), 2000) @ hull
    assert distance <= np.linalg.norm(samples - far, axis=1).min() + 1e-9
    from scipy.optimize import minimize

    best = minimize(
        lambda w: np.sum((w @ hull - far) ** 2),
        np.full(corners, 1.0 / corners),
        bounds=[(0.0, 1.0)] * corners,
        constraints={"type": "eq", "fun": lambda w: w.sum() - 1.0},
    )
    assert distance == pytest.approx(np.sqrt(best.fun), abs=2e-3)


@pytest.mark.parametrize(
    ("options", "says"),
    [({"k": -1.0}, "k is -1.0"), ({"heights": [1.0]}, "heights are"), ({"heights": [0.0] * 2}, "heights")],
)
def test_bad_values_are_refused(options, says):
    with pytest.raises(RangeError, match=says):
        Containment(0, TimeVaryingCommunicator(0, 2, [1], [1], transport=InProcessTransport()), **options)
