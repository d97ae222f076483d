import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import (
    DirectedGradientTracking,
    GradientTracking,
    QuadraticProblem,
    graphs,
    run_together,
)

SEEDS = st.integers(0, 10_000)


def problems(size, seed, n=3):
    """Costs with curvatures from 1 to 3, and the minimum of their sum."""
    dice = np.random.default_rng(seed)
    parts = []
    for _ in range(size):
        turn = np.linalg.qr(dice.normal(size=(n, n)))[0]
        parts.append(QuadraticProblem(turn @ np.diag(dice.uniform(0.5, 1.5, n)) @ turn.T, dice.uniform(-3, 3, n)))
    P, q = sum(one.P for one in parts), sum(one.q for one in parts)
    return parts, np.linalg.solve(2 * P, -q)


@settings(max_examples=5)
@given(seed=SEEDS, size=st.integers(2, 6))
def test_finds_the_minimum_of_the_sum(team, seed, size):
    parts, minimum = problems(size, seed)
    agents = team(graphs.binomial_random_graph(size, 0.6, seed), parts)
    algorithms = [GradientTracking(agent, np.zeros(3), stepsize=0.03) for agent in agents]
    run_together(algorithms, 900)
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), minimum, atol=1e-5)


@settings(max_examples=3)
@given(seed=SEEDS)
def test_over_graphs_that_change(team, jointly_connected, seed):
    parts, minimum = problems(5, seed)
    largest, schedule = jointly_connected(5, seed)
    agents = team(largest, parts, schedule=schedule)
    algorithms = [GradientTracking(agent, np.ones(3), stepsize=0.02) for agent in agents]
    run_together(algorithms, 900)
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), minimum, atol=1e-4)


def test_error_shrinks_by_a_factor(team):
    """The rate is linear: as many rounds, the same factor."""
    parts, minimum = problems(4, 1)
    algorithms = [GradientTracking(agent, np.zeros(3), stepsize=0.05) for agent in team(graphs.ring_graph(4), parts)]
    errors = []
    run_together(algorithms, 300, until=lambda: errors.append(max(np.abs(one.x - minimum).max() for one in algorithms)))
    assert errors[199] < 0.1 * errors[99] < 0.01 * errors[0]


@settings(max_examples=6)
@given(seed=SEEDS, size=st.integers(2, 5))
def test_directed_graphs_with_losses(team, in_any_order, seed, size):
    parts, minimum = problems(size, seed)
    agents = team(graphs.binomial_random_graph(size, 0.6, seed, "directed"), parts, loss=0.2, seed=seed)
    algorithms = [DirectedGradientTracking(agent, np.zeros(3), stepsize=0.02) for agent in agents]
    in_any_order(algorithms, 1500, seed)
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), minimum, atol=1e-4)


def test_plain_tracking_misses_the_minimum_with_losses(team, in_any_order):
    parts, minimum = problems(4, 2)
    agents = team(graphs.ring_graph(4), parts, loss=0.2)
    algorithms = [GradientTracking(agent, np.zeros(3), stepsize=0.02) for agent in agents]
    in_any_order(algorithms, 1000)
    assert max(np.abs(one.x - minimum).max() for one in algorithms) > 1e-2


@pytest.mark.parametrize("kind", [GradientTracking, DirectedGradientTracking])
def test_step_must_be_positive(team, kind):
    agent = team(graphs.path_graph(2), problems(2, 0)[0])[0]
    with pytest.raises(RangeError, match="stepsize is 0"):
        kind(agent, np.zeros(3), stepsize=0.0)
