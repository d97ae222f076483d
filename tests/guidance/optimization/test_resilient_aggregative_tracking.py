"""Tracking that stays right when agents leave and come back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.guidance.optimization import (
    AggregativeTracking,
    ResilientAggregativeTracking,
    RobustAggregativeTracking,
    SurveillanceProblem,
    graphs,
    run_together,
)


def problems_of(size, seed):
    dice = np.random.default_rng(seed)
    return [SurveillanceProblem(dice.uniform(-2, 2, 2), (0.2, -0.1)) for _ in range(size)]


def optimum(problems):
    """Half-way between intruder and target, with all weights 1."""
    return [(problem.intruder + problem.target) / 2 for problem in problems]


def bias(algorithms):
    """Return by how much the tracked means miss the means of these agents: 0 when sums are right."""
    x, s, y, by_mean = (np.array([getattr(one, name) for one in algorithms]) for name in ("x", "s", "y", "_by_mean"))
    return np.abs([(s - x).sum(axis=0), (y - by_mean).sum(axis=0)]).max()


def test_with_everybody_there_it_is_aggregative_tracking(team):
    problems, adjacency = problems_of(4, 2), graphs.binomial_random_graph(4, 0.5, 3)
    both = []
    for kind in (AggregativeTracking, ResilientAggregativeTracking):
        algorithms = [kind(agent, np.zeros(2), stepsize=0.02) for agent in team(adjacency, problems)]
        run_together(algorithms, 100)
        both.append([(one.x, one.s, one.y) for one in algorithms])
    np.testing.assert_array_equal(*both)


@settings(max_examples=8)
@given(seed=st.integers(0, 10_000), size=st.integers(3, 6), left_at=st.integers(0, 200))
def test_the_others_find_their_own_optimum_when_one_leaves(team, seed, size, left_at):
    problems = problems_of(size, seed)
    algorithms = [
        ResilientAggregativeTracking(agent, np.ones(2) * agent.id, stepsize=0.02)
        for agent in team(1.0 - np.eye(size), problems)
    ]
    run_together(algorithms, left_at)
    algorithms[-1].begin_round()  # its last word arrives, it hears none
    rest = algorithms[:-1]
    run_together(rest, 1)
    for one in rest:
        one.leave([size - 1])
        one.agent.set_neighbors(set(range(size - 1)) - {one.agent.id}, one.agent.out_neighbors)
    assert bias(rest) < 1e-9
    run_together(rest, 700)
    np.testing.assert_allclose([one.x for one in rest], optimum(problems)[:-1], atol=1e-3)


@pytest.mark.parametrize("seed", range(6))
def test_sums_are_right_again_whoever_left_whom_for_how_long(team, seed):
    """One end of a link may give up the other, which learns of it by the next message."""
    dice, problems = np.random.default_rng(seed), problems_of(4, seed)
    algorithms = [
        ResilientAggregativeTracking(agent, np.zeros(2), stepsize=0.02, session=100 + agent.id)
        for agent in team(1.0 - np.eye(4), problems)
    ]
    for _ in range(5):
        run_together(algorithms, int(dice.integers(1, 20)))
        one, other = dice.permutation(4)[:2].tolist()
        algorithms[one].leave([other])
        if dice.integers(2):
            run_together(algorithms, int(dice.integers(1, 3)))
            assert bias(algorithms) < 1e-9
            algorithms[one].rejoin([other])
    for one in algorithms:
        one.rejoin(range(4))
    run_together(algorithms, 1)
    assert bias(algorithms) < 1e-9
    run_together(algorithms, 700)
    np.testing.assert_allclose([one.x for one in algorithms], optimum(problems), atol=1e-3)


def test_who_was_started_again_is_noticed(team):
    problems = problems_of(3, 1)
    agents = team(1.0 - np.eye(3), problems)
    algorithms = [ResilientAggregativeTracking(agent, np.zeros(2), stepsize=0.02) for agent in agents]
    run_together(algorithms, 50)
    algorithms[2] = ResilientAggregativeTracking(agents[2], np.ones(2), stepsize=0.02, session=500)
    run_together(algorithms, 2)
    assert bias(algorithms) < 1e-9


def test_messages_that_are_none_are_left_out(team):
    agents = team(1.0 - np.eye(2), problems_of(2, 1))
    one = ResilientAggregativeTracking(agents[0], np.zeros(2), stepsize=0.02)
    for message in (None, 3, "xy", ([1.0], ()), (np.zeros((2, 2)), ()), (np.full((2, 2), np.nan), ((0, 0),))):
        one.begin_round()
        agents[1].neighbors_send(message)
        agents[1].collect()
        one.finish_round()
    assert bias([one]) < 1e-12


def test_flows_are_taken_back_as_well(team):
    problems = problems_of(4, 3)
    algorithms = [
        RobustAggregativeTracking(agent, np.zeros(2), stepsize=0.02)
        for agent in team(1.0 - np.eye(4), problems, loss=0.0)
    ]
    run_together(algorithms, 60)
    rest = algorithms[:-1]
    run_together(rest, 2)
    for one in rest:
        one.leave([3])
    run_together(rest, 700)
    np.testing.assert_allclose([one.x for one in rest], optimum(problems)[:-1], atol=1e-3)
