"""Dual decomposition and ADMM solve the same problems: costs and constraints of each agent, one common point."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import (
    ADMM,
    DualDecomposition,
    InfeasibleError,
    QuadraticProblem,
    graphs,
    run_together,
)

SEEDS = st.integers(0, 10_000)


def problems(size, seed, n=2, slack=(0.05, 0.5)):
    """Parts with half-planes around a common point, and the optimum of them all."""
    dice = np.random.default_rng(seed)
    inside = dice.normal(size=n)
    parts = []
    for _ in range(size):
        A = dice.normal(size=(2, n))
        P = np.diag(dice.uniform(0.5, 1.5, n))
        parts.append(QuadraticProblem(P, dice.uniform(-3, 3, n), A=A, b=A @ inside + dice.uniform(*slack, 2)))
    whole = QuadraticProblem(
        sum(one.P for one in parts),
        sum(one.q for one in parts),
        A=np.vstack([one.A for one in parts]),
        b=np.concatenate([one.b for one in parts]),
    )
    return parts, whole.minimize()


def check(algorithms, optimum, atol):
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), optimum, atol=atol)
        assert np.all(one.agent.problem.A @ one.get_result() <= one.agent.problem.b + 1e-9)


@settings(max_examples=6)
@given(seed=SEEDS, size=st.integers(2, 5))
def test_prices_make_agents_agree(team, seed, size):
    parts, optimum = problems(size, seed)
    algorithms = [
        DualDecomposition(agent, stepsize=0.1) for agent in team(graphs.binomial_random_graph(size, 0.6, seed), parts)
    ]
    run_together(algorithms, 800)
    check(algorithms, optimum, 1e-2)


@settings(max_examples=2)
@given(seed=SEEDS)
def test_prices_over_graphs_that_change(team, jointly_connected, seed):
    parts, optimum = problems(4, seed)
    largest, schedule = jointly_connected(4, seed)
    algorithms = [DualDecomposition(agent, stepsize=0.4) for agent in team(largest, parts, schedule=schedule)]
    run_together(algorithms, 500)
    check(algorithms, optimum, 1e-3)


@settings(max_examples=4)
@given(seed=SEEDS, size=st.integers(2, 4))
def test_prices_with_losses(team, in_any_order, seed, size):
    """As near as half the step comes without losses, which is slow where constraints are nearly parallel."""
    parts, optimum = problems(size, seed, slack=(0.3, 1.0))
    adjacency = graphs.binomial_random_graph(size, 0.6, seed)
    lossy = [DualDecomposition(agent, stepsize=0.4) for agent in team(adjacency, parts, loss=0.2, seed=seed)]
    in_any_order(lossy, 300, seed)
    calm = [DualDecomposition(agent, stepsize=0.2) for agent in team(adjacency, parts)]
    run_together(calm, 300)
    error = max(np.abs(one.get_result() - optimum).max() for one in calm)
    check(lossy, optimum, 1e-3 + 2.0 * error)


def test_the_ends_of_an_edge_pay_each_other(team):
    """Prices add up to nothing in every round of a lock step, and again after a message that was lost."""
    parts, _ = problems(3, 1)
    algorithms = [DualDecomposition(agent, stepsize=0.2) for agent in team(graphs.path_graph(3), parts, loss=0.0)]
    for _ in range(10):
        run_together(algorithms, 1)
        np.testing.assert_allclose(sum(one.price for one in algorithms), 0.0, atol=1e-12)
    deaf = algorithms[2]
    for one in algorithms:
        one.begin_round()
    deaf.agent.collect()
    for one in algorithms:
        one.finish_round()
    assert np.abs(sum(one.price for one in algorithms)).max() > 1e-4
    run_together(algorithms, 1)
    np.testing.assert_allclose(sum(one.price for one in algorithms), 0.0, atol=1e-12)


@settings(max_examples=6)
@given(seed=SEEDS, size=st.integers(2, 5))
def test_admm_finds_the_optimum(team, seed, size):
    parts, optimum = problems(size, seed)
    algorithms = [ADMM(agent) for agent in team(graphs.binomial_random_graph(size, 0.6, seed), parts)]
    run_together(algorithms, 500)
    check(algorithms, optimum, 1e-3)


@settings(max_examples=6)
@given(seed=SEEDS, size=st.integers(2, 5))
def test_admm_with_losses(team, in_any_order, seed, size):
    parts, optimum = problems(size, seed)
    agents = team(graphs.binomial_random_graph(size, 0.6, seed), parts, loss=0.2, seed=seed)
    algorithms = [ADMM(agent, relaxation=0.7) for agent in agents]
    in_any_order(algorithms, 700, seed)
    check(algorithms, optimum, 1e-3)


@settings(max_examples=2)
@given(seed=SEEDS)
def test_admm_over_graphs_that_change(team, jointly_connected, seed):
    parts, optimum = problems(4, seed)
    largest, schedule = jointly_connected(4, seed)
    algorithms = [ADMM(agent) for agent in team(largest, parts, schedule=schedule)]
    run_together(algorithms, 600)
    check(algorithms, optimum, 1e-3)


def test_one_agent_alone(team):
    parts, optimum = problems(1, 1)
    algorithm = ADMM(team(np.zeros((1, 1)), parts)[0])
    run_together([algorithm], 1)
    check([algorithm], optimum, 1e-9)


def test_own_constraints_that_contradict_each_other_are_said_at_once(team):
    part = QuadraticProblem([[1.0]], [0.0], A=[[1.0], [-1.0]], b=[-1.0, -1.0])
    agent = team(graphs.path_graph(2), [part])[0]
    for kind in (ADMM, DualDecomposition):
        with pytest.raises(InfeasibleError):
            kind(agent)


def test_numbers_outside_their_range(team):
    agent = team(graphs.path_graph(2), problems(2, 0)[0])[0]
    with pytest.raises(RangeError, match="relaxation is 0"):
        ADMM(agent, relaxation=0.0)
    with pytest.raises(RangeError, match="penalty is -1"):
        ADMM(agent, penalty=-1.0)
    with pytest.raises(RangeError, match="stepsize is nan"):
        DualDecomposition(agent, stepsize=float("nan"))
