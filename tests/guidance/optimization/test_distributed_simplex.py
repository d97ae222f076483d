import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import DistributedSimplex, LinearProblem, graphs, run_together

SEEDS = st.integers(0, 10_000)


def shared_program(size, seed, m=3, each=3):
    """A program with an optimum: some columns of every agent, costs not negative; and its least cost."""
    dice = np.random.default_rng(seed)
    b = dice.uniform(-2.0, 2.0, m)
    parts = [LinearProblem(dice.uniform(0, 3, each), dice.normal(size=(m, each)), b) for _ in range(size)]
    costs = np.concatenate([*(one.costs for one in parts), np.full(m, 500.0)])
    A = np.hstack([*(one.columns for one in parts), np.diag(np.where(b < 0, -1.0, 1.0))])
    return parts, linprog(costs, A_eq=A, b_eq=b).fun


def check(algorithms, least):
    for one in algorithms:
        assert least == pytest.approx(one.J, rel=1e-6, abs=1e-6)
        np.testing.assert_array_equal(one.B, algorithms[0].B)
        assert one.x_dual @ one.agent.problem.b == pytest.approx(one.J, rel=1e-6, abs=1e-6)


@settings(max_examples=15)
@given(seed=SEEDS, size=st.integers(2, 6))
def test_all_find_the_same_best_basis(team, seed, size):
    parts, least = shared_program(size, seed)
    algorithms = [
        DistributedSimplex(agent) for agent in team(graphs.binomial_random_graph(size, 0.6, seed, "directed"), parts)
    ]
    run_together(algorithms, 30)
    check(algorithms, least)


@settings(max_examples=8)
@given(seed=SEEDS)
def test_over_graphs_that_change(team, jointly_connected, seed):
    parts, least = shared_program(5, seed)
    largest, schedule = jointly_connected(5, seed)
    algorithms = [DistributedSimplex(agent) for agent in team(largest, parts, schedule=schedule)]
    run_together(algorithms, 60)
    check(algorithms, least)


@settings(max_examples=8)
@given(seed=SEEDS)
def test_with_losses(team, in_any_order, seed):
    parts, least = shared_program(5, seed)
    algorithms = [DistributedSimplex(agent) for agent in team(graphs.ring_graph(5, "directed"), parts, loss=0.2)]
    in_any_order(algorithms, 60, seed)
    check(algorithms, least)


def test_it_stops_when_nothing_changes(team):
    parts, least = shared_program(4, 1)
    algorithms = [DistributedSimplex(agent, stop_iterations=5) for agent in team(graphs.ring_graph(4), parts)]
    assert run_together(algorithms, 100) < 20
    check(algorithms, least)


def test_what_cannot_be_satisfied_is_said(team):
    b = [1.0, 1.0]
    parts = [LinearProblem([1.0], [[1.0], [0.0]], b), LinearProblem([], np.zeros((2, 0)), b)]
    algorithms = [DistributedSimplex(agent) for agent in team(graphs.path_graph(2), parts)]
    run_together(algorithms, 3)
    for one in algorithms:
        assert not one.is_feasible
        np.testing.assert_allclose(one.artificial, [0.0, 1.0])
        assert pytest.approx(501.0) == one.J


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([1.0], [[1.0, 2.0]], [1.0]), "1 costs and 2 columns"),
        (([1.0], [[1.0]], [1.0, 2.0]), "columns have shape"),
        (([np.nan], [[1.0]], [1.0]), "finite"),
        (([1.0], [[1.0]], [np.inf]), "b is"),
    ],
)
def test_bad_problems_are_refused(arguments, says):
    with pytest.raises(RangeError, match=says):
        LinearProblem(*arguments)
