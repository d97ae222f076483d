import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import (
    AggregativeTracking,
    ResilientAggregativeTracking,
    RobustAggregativeTracking,
    SurveillanceProblem,
    graphs,
    run_together,
)

INTRUDERS = np.array([(-1.0, 1.0), (-1.0, -1.0), (1.0, 0.0)])
STARTS = np.array([(-0.5, -0.5), (0.0, -0.5), (0.5, -0.5)])
PATH = graphs.binomial_random_graph(3, 0.5, 3)


@pytest.mark.parametrize(
    ("stepsize", "expected"), [(1e-3, (573, 1145, 1717)), (5e-3, (112, 224, 335))], ids=["1e-3", "5e-3"]
)
def test_rounds_of_the_static_example(team, stepsize, expected):
    problems = [SurveillanceProblem(intruder, (0.0, 0.0)) for intruder in INTRUDERS]
    algorithms = [
        AggregativeTracking(agent, start, stepsize=stepsize)
        for agent, start in zip(team(PATH, problems), STARTS, strict=True)
    ]
    errors = []
    limits = [(-0.5, 0.5), (-0.5, -0.5), (0.5, 0.0)]
    run_together(
        algorithms,
        expected[-1] + 50,
        until=lambda: errors.append(np.abs(np.array([one.x for one in algorithms]) - limits).max()),
    )
    assert tuple(1 + int(np.argmax(np.array(errors) < bound)) for bound in (0.1, 0.01, 0.001)) == expected


def optimum(problems):
    """Solve the whole problem at once: all gradients are linear."""
    size, n = len(problems), problems[0].target.size

    def gradient(flat):
        x = flat.reshape(size, n)
        both = [problem.gradients(one, x.mean(axis=0)) for problem, one in zip(problems, x, strict=True)]
        return (np.array([own for own, _ in both]) + np.mean([mean for _, mean in both], axis=0)).ravel()

    zero = gradient(np.zeros(size * n))
    matrix = np.array([gradient(unit) - zero for unit in np.eye(size * n)]).T
    return np.linalg.solve(matrix, -zero).reshape(size, n)


def random_problems(size, n, seed):
    dice = np.random.default_rng(seed)
    target = dice.uniform(-1, 1, n)
    return [
        SurveillanceProblem(
            dice.uniform(-2, 2, n),
            target,
            gamma_intruder=dice.uniform(0.5, 1.5),
            gamma_target=dice.uniform(0.5, 1.5),
            gamma_shape=dice.uniform(0.5, 1.5),
        )
        for _ in range(size)
    ]


@settings(max_examples=6)
@given(seed=st.integers(0, 10_000), size=st.integers(2, 5), n=st.integers(1, 4))
def test_finds_the_optimum_in_any_dimension(team, seed, size, n):
    problems = random_problems(size, n, seed)
    agents = team(graphs.binomial_random_graph(size, 0.6, seed), problems)
    algorithms = [AggregativeTracking(agent, np.zeros(n), stepsize=0.02) for agent in agents]
    run_together(algorithms, 900)
    np.testing.assert_allclose([one.get_result() for one in algorithms], optimum(problems), atol=1e-3)


def test_over_graphs_that_change(team, jointly_connected):
    problems = random_problems(5, 2, 3)
    largest, schedule = jointly_connected(5, 3)
    algorithms = [
        AggregativeTracking(agent, np.zeros(2), stepsize=0.01) for agent in team(largest, problems, schedule=schedule)
    ]
    run_together(algorithms, 1500)
    np.testing.assert_allclose([one.get_result() for one in algorithms], optimum(problems), atol=1e-3)


@settings(max_examples=6)
@given(seed=st.integers(0, 10_000), size=st.integers(2, 5))
def test_robust_tracking_bears_losses(team, in_any_order, seed, size):
    problems = random_problems(size, 2, seed)
    agents = team(graphs.binomial_random_graph(size, 0.6, seed), problems, loss=0.2, seed=seed)
    algorithms = [RobustAggregativeTracking(agent, np.zeros(2), stepsize=0.02) for agent in agents]
    in_any_order(algorithms, 600, seed)
    np.testing.assert_allclose([one.get_result() for one in algorithms], optimum(problems), atol=1e-3)


@pytest.mark.parametrize("kind", [AggregativeTracking, ResilientAggregativeTracking])
def test_tracking_by_what_was_said_last_misses_the_optimum_with_losses(team, in_any_order, kind):
    """Tracking has to conserve sums over all agents; an undetected loss of a message changes them."""
    problems = random_problems(4, 2, 3)
    algorithms = [
        kind(agent, np.ones(2) * agent.id, stepsize=0.02) for agent in team(graphs.ring_graph(4), problems, loss=0.2)
    ]
    in_any_order(algorithms, 600)
    assert np.abs(np.array([one.x for one in algorithms]) - optimum(problems)).max() > 1e-2


def test_an_optimum_that_moved_is_found_again(team):
    """Sums that are tracked stay right when the problem changes between rounds."""
    agents = team(PATH, random_problems(3, 2, 1))
    algorithms = [AggregativeTracking(agent, np.zeros(2), stepsize=0.02) for agent in agents]
    run_together(algorithms, 100)
    moved = random_problems(3, 2, 2)
    for agent, problem in zip(agents, moved, strict=True):
        agent.set_problem(problem)
    run_together(algorithms, 900)
    np.testing.assert_allclose([one.get_result() for one in algorithms], optimum(moved), atol=1e-4)


def test_what_is_missing_drops_out():
    x, sigma = np.array([1.0, 2.0]), np.array([0.0, 1.0])
    own, mean = SurveillanceProblem(intruder=(0.0, 0.0)).gradients(x, sigma)
    np.testing.assert_array_equal(own, 2 * (x - sigma) + 2 * x)
    np.testing.assert_array_equal(mean, -2 * (x - sigma))
    own, mean = SurveillanceProblem(target=(0.0, 0.0)).gradients(x, sigma)
    np.testing.assert_array_equal(own, 2 * (x - sigma))
    np.testing.assert_array_equal(mean, -2 * (x - sigma) + 2 * sigma)


def test_gradients_are_those_of_the_value():
    problem = random_problems(1, 3, 5)[0]
    dice = np.random.default_rng(0)
    x, sigma = dice.normal(size=(2, 3))
    own, mean = problem.gradients(x, sigma)

    def slope(by_own, by_mean):
        return (problem.value(x + by_own, sigma + by_mean) - problem.value(x - by_own, sigma - by_mean)) / 2e-6

    for k, step in enumerate(1e-6 * np.eye(3)):
        assert slope(step, 0.0) == pytest.approx(own[k], abs=1e-6)
        assert slope(0.0, step) == pytest.approx(mean[k], abs=1e-6)


def test_nothing_to_guard_is_refused():
    with pytest.raises(RangeError, match="neither intruder nor target"):
        SurveillanceProblem()
    with pytest.raises(RangeError, match="gamma_shape is -1"):
        SurveillanceProblem((0.0, 0.0), gamma_shape=-1.0)
