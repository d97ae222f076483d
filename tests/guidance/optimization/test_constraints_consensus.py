import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.guidance.optimization import (
    ConstraintsConsensus,
    InfeasibleError,
    QuadraticProblem,
    graphs,
    run_together,
)

SEEDS = st.integers(0, 10_000)


def problems(size, seed, n=3):
    """The same cost for all, half-planes of each, which may contradict each other; and the optimum, if there is one."""
    dice = np.random.default_rng(seed)
    P, q = np.eye(n), dice.uniform(-4, 4, n)
    inside = dice.normal(size=n)
    parts = []
    for _ in range(size):
        A = dice.normal(size=(3, n))
        parts.append(QuadraticProblem(P, q, A=A, b=A @ inside + dice.uniform(-0.05, 0.6, 3)))
    whole = QuadraticProblem(P, q, A=np.vstack([one.A for one in parts]), b=np.concatenate([one.b for one in parts]))
    try:
        return parts, whole.minimize()
    except InfeasibleError:
        return parts, np.full(n, np.nan)


def check(algorithms, optimum):
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), optimum, atol=1e-8)
        assert one.is_feasible == np.isfinite(optimum).all()
        assert len(one.basis) <= len(optimum)


@settings(max_examples=20)
@given(seed=SEEDS, size=st.integers(1, 6))
def test_all_find_the_optimum_of_all_constraints(team, seed, size):
    parts, optimum = problems(size, seed)
    adjacency = graphs.binomial_random_graph(size, 0.6, seed, "directed") if size > 1 else np.zeros((1, 1))
    algorithms = [ConstraintsConsensus(agent) for agent in team(adjacency, parts)]
    run_together(algorithms, 25)
    check(algorithms, optimum)


@settings(max_examples=10)
@given(seed=SEEDS)
def test_over_graphs_that_change(team, jointly_connected, seed):
    parts, optimum = problems(5, seed)
    largest, schedule = jointly_connected(5, seed)
    algorithms = [ConstraintsConsensus(agent) for agent in team(largest, parts, schedule=schedule)]
    run_together(algorithms, 60)
    check(algorithms, optimum)


@settings(max_examples=10)
@given(seed=SEEDS)
def test_with_losses(team, in_any_order, seed):
    parts, optimum = problems(5, seed)
    agents = team(graphs.ring_graph(5, "directed"), parts, loss=0.2, seed=seed)
    algorithms = [ConstraintsConsensus(agent) for agent in agents]
    in_any_order(algorithms, 80, seed)
    check(algorithms, optimum)


def test_a_contradiction_is_known_to_all(team):
    parts = [
        QuadraticProblem([[1.0]], [0.0], A=[[1.0]], b=[-1.0]),
        QuadraticProblem([[1.0]], [0.0]),
        QuadraticProblem([[1.0]], [0.0], A=[[-1.0]], b=[-1.0]),
    ]
    algorithms = [ConstraintsConsensus(agent) for agent in team(graphs.path_graph(3), parts)]
    run_together(algorithms, 4)
    assert [one.is_feasible for one in algorithms] == [False] * 3


def test_it_stops_when_nothing_changes(team):
    parts, optimum = problems(4, 5)
    algorithms = [ConstraintsConsensus(agent, stop_iterations=5) for agent in team(graphs.ring_graph(4), parts)]
    assert run_together(algorithms, 100) < 20
    check(algorithms, optimum)
    assert algorithms[0].agent.problem.value(optimum) == pytest.approx(parts[0].value(optimum))
