"""How fast each algorithm finds the optimum: the rates that were published, on random instances.

Where a theorem has numbers these are asserted, otherwise that the error shrinks by a factor per round.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from crazychoir_fw.guidance.optimization import (
    ADMM,
    AggregativeTracking,
    Consensus,
    ConstraintsConsensus,
    DirectedGradientTracking,
    DistributedSimplex,
    DualDecomposition,
    GradientTracking,
    LinearProblem,
    MaxConsensus,
    PushSumConsensus,
    QuadraticProblem,
    ResilientAggregativeTracking,
    RobustAggregativeTracking,
    SurveillanceProblem,
    graphs,
    run_together,
)

SEEDS = st.integers(0, 10_000)
DIMENSION = 2


def stacked(algorithms, name="x"):
    return np.array([getattr(one, name) for one in algorithms])


def after_each_round(algorithms, rounds, measure):
    """Return what is measured at the begin and after each round."""
    measured = [measure()]
    run_together(algorithms, rounds, until=lambda: measured.append(measure()))
    return measured


def diameter(adjacency):
    """Return the longest way between two agents."""
    near = np.eye(len(adjacency)) + adjacency
    power, ways = near, 1
    while np.any(power == 0.0):
        power, ways = power @ near, ways + 1
    return ways


# -------------------------------------------------------------------- values


@settings(max_examples=10)
@given(seed=SEEDS, size=st.integers(2, 7))
def test_consensus_contracts_by_the_second_singular_value(team, seed, size):
    """Xiao, Boyd 2004: the distance from the mean shrinks by the norm of W - 11'/N in every round."""
    adjacency = graphs.binomial_random_graph(size, 0.5, seed)
    x = np.random.default_rng(seed).uniform(-5.0, 5.0, (size, 3))
    factor = np.linalg.norm(graphs.metropolis_hastings(adjacency) - 1.0 / size, 2)
    algorithms = [Consensus(agent, one) for agent, one in zip(team(adjacency), x, strict=True)]
    distances = after_each_round(algorithms, 30, lambda: np.linalg.norm(stacked(algorithms) - x.mean(axis=0)))
    assert np.all(np.array(distances[1:]) <= factor * np.array(distances[:-1]) + 1e-12)


@settings(max_examples=5)
@given(seed=SEEDS)
def test_consensus_over_graphs_that_change_contracts_in_every_period(team, jointly_connected, seed):
    """Nedic, Olshevsky, Ozdaglar, Tsitsiklis 2009: squares shrink by 1 - w/(2 N^2) each time that the graphs are
    connected together, where no weight is below w."""
    size, period = 5, 3
    largest, schedule = jointly_connected(size, seed)
    x = np.random.default_rng(seed).uniform(-5.0, 5.0, size)
    algorithms = [Consensus(agent, one) for agent, one in zip(team(largest, schedule=schedule), x, strict=True)]
    squares = after_each_round(algorithms, 60, lambda: np.sum((stacked(algorithms) - x.mean()) ** 2))[::period]
    bound = 1.0 - (1.0 / size) / (2.0 * size**2)
    assert np.all(np.array(squares[1:]) <= bound * np.array(squares[:-1]) + 1e-20)


@settings(max_examples=5)
@given(seed=SEEDS)
def test_push_sum_finds_the_mean_geometrically_over_directed_graphs_that_change(
    team, jointly_connected, factor_per_round, seed
):
    """Nedic, Olshevsky 2015: geometric over jointly strongly connected graphs, at worst 1 - N^(-N B)
    per B rounds."""
    largest, schedule = jointly_connected(5, seed, "directed")
    x = np.random.default_rng(seed).uniform(-5.0, 5.0, 5)
    algorithms = [PushSumConsensus(agent, one) for agent, one in zip(team(largest, schedule=schedule), x, strict=True)]
    errors = after_each_round(
        algorithms, 300, lambda: max(abs(float(one.get_result()) - x.mean()) for one in algorithms)
    )
    assert factor_per_round(errors) < 0.98
    assert errors[-1] < 1e-2


@settings(max_examples=10)
@given(seed=SEEDS, size=st.integers(2, 7))
def test_the_maximum_is_known_after_as_many_rounds_as_the_graph_is_wide(team, seed, size):
    adjacency = graphs.binomial_random_graph(size, 0.4, seed, "directed")
    x = np.random.default_rng(seed).normal(size=size)
    algorithms = [MaxConsensus(agent, one) for agent, one in zip(team(adjacency), x, strict=True)]
    run_together(algorithms, diameter(adjacency))
    assert [float(one.x) for one in algorithms] == [x.max()] * size


@settings(max_examples=5)
@given(seed=SEEDS)
def test_the_maximum_travels_on_in_every_period(team, jointly_connected, seed):
    """In each period the maximum reaches at least one more agent: N - 1 periods are enough."""
    largest, schedule = jointly_connected(5, seed, "directed")
    x = np.random.default_rng(seed).normal(size=5)
    algorithms = [MaxConsensus(agent, one) for agent, one in zip(team(largest, schedule=schedule), x, strict=True)]
    run_together(algorithms, 3 * 4)
    assert [float(one.x) for one in algorithms] == [x.max()] * 5


# -------------------------------------------------------------------- gradients


def costs(size, seed):
    """Costs with curvatures from 1 to 3, and the minimum of their sum."""
    dice = np.random.default_rng(seed)
    parts = []
    for _ in range(size):
        turn = np.linalg.qr(dice.normal(size=(DIMENSION, DIMENSION)))[0]
        P = turn @ np.diag(dice.uniform(0.5, 1.5, DIMENSION)) @ turn.T
        parts.append(QuadraticProblem(P, dice.uniform(-3, 3, DIMENSION)))
    return parts, np.linalg.solve(2 * sum(one.P for one in parts), -sum(one.q for one in parts))


def least_curvatures(parts):
    return [2.0 * np.linalg.eigvalsh(one.P)[0] for one in parts]


@settings(max_examples=5)
@given(seed=SEEDS, size=st.integers(2, 6))
def test_gradient_tracking_contracts_as_published(team, seed, size):
    """Qu, Li 2018: deviations of tracked gradients and of points, and distance of the mean point, are at most
    a matrix times those of the round before."""
    parts, minimum = costs(size, seed)
    adjacency = graphs.binomial_random_graph(size, 0.6, seed)
    step, steepest = 0.05, max(2.0 * np.linalg.eigvalsh(one.P)[-1] for one in parts)
    # the mean cost: curved at least as much as its parts are on average
    mean_curvature = 2.0 * np.linalg.eigvalsh(sum(one.P for one in parts) / size)[0]
    sigma = np.linalg.norm(graphs.metropolis_hastings(adjacency) - 1.0 / size, 2)
    both = steepest * step
    shrink = max(abs(1.0 - mean_curvature * step), abs(1.0 - both))
    bound = np.array(
        [[sigma + both, steepest * (both + 2.0), step * steepest**2], [step, sigma, 0.0], [0.0, both, shrink]]
    )

    algorithms = [GradientTracking(agent, np.zeros(DIMENSION), stepsize=step) for agent in team(adjacency, parts)]

    def deviations():
        x, y = stacked(algorithms), stacked(algorithms, "y")
        mean = x.mean(axis=0)
        return [
            np.linalg.norm(y - y.mean(axis=0)),
            np.linalg.norm(x - mean),
            np.sqrt(size) * np.linalg.norm(mean - minimum),
        ]

    measured = np.array(after_each_round(algorithms, 100, deviations))
    assert np.all(measured[1:] <= measured[:-1] @ bound.T + 1e-12)


@pytest.mark.parametrize("changes", [False, True], ids=["one graph", "changing graphs"])
@settings(max_examples=3)
@given(seed=SEEDS)
def test_gradient_tracking_is_linear(team, jointly_connected, factor_per_round, changes, seed):
    """Nedic, Olshevsky, Shi 2017 (DIGing): (1 - step m/1.5)^(1/(2B)) per round where any B graphs in a row are
    connected together and costs curve at least with m on average."""
    parts, minimum = costs(5, seed)
    largest, schedule = jointly_connected(5, seed)
    agents = team(largest, parts, schedule=schedule if changes else None)
    algorithms = [GradientTracking(agent, np.zeros(DIMENSION), stepsize=0.03) for agent in agents]
    errors = after_each_round(algorithms, 250, lambda: np.abs(stacked(algorithms) - minimum).max())
    # five in a row hold one of the periods of three whole
    window = 5 if changes else 1
    assert factor_per_round(errors, after=50) <= (1.0 - 0.03 * np.mean(least_curvatures(parts)) / 1.5) ** (0.5 / window)


@pytest.mark.parametrize("changes", [False, True], ids=["one graph", "changing graphs"])
@settings(max_examples=3)
@given(seed=SEEDS)
def test_directed_gradient_tracking_is_linear(team, jointly_connected, factor_per_round, changes, seed):
    """Tian, Sun, Scutari 2020 (ASY-SONATA): linear for small steps under any loss, as long as a message of each
    agent arrives once in a while; a missing edge counts as a lost message."""
    parts, minimum = costs(4, seed)
    largest, schedule = jointly_connected(4, seed, "directed")
    agents = team(largest, parts, schedule=schedule if changes else None)
    algorithms = [DirectedGradientTracking(agent, np.zeros(DIMENSION), stepsize=0.1) for agent in agents]
    errors = after_each_round(algorithms, 400, lambda: np.abs(stacked(algorithms) - minimum).max())
    assert factor_per_round(errors, after=20) < 0.99
    assert errors[-1] < 1e-3


# -------------------------------------------------------------------- aggregative


def surveillance(size, seed):
    """Problems with different weights, the optimum, and the least curvature of the sum of all costs."""
    dice = np.random.default_rng(seed)
    target = dice.uniform(-1, 1, DIMENSION)
    problems = [
        SurveillanceProblem(
            dice.uniform(-2, 2, DIMENSION),
            target,
            gamma_intruder=dice.uniform(0.5, 1.5),
            gamma_target=dice.uniform(0.5, 1.5),
            gamma_shape=dice.uniform(0.5, 1.5),
        )
        for _ in range(size)
    ]

    def gradient(flat):
        x = flat.reshape(size, DIMENSION)
        both = [problem.gradients(one, x.mean(axis=0)) for problem, one in zip(problems, x, strict=True)]
        return (np.array([own for own, _ in both]) + np.mean([mean for _, mean in both], axis=0)).ravel()

    zero = gradient(np.zeros(size * DIMENSION))
    hessian = np.array([gradient(unit) - zero for unit in np.eye(size * DIMENSION)]).T
    optimum = np.linalg.solve(hessian, -zero).reshape(size, DIMENSION)
    return problems, optimum, np.linalg.eigvalsh((hessian + hessian.T) / 2.0)[0]


@pytest.mark.parametrize("changes", [False, True], ids=["one graph", "changing graphs"])
@pytest.mark.parametrize("kind", [AggregativeTracking, ResilientAggregativeTracking, RobustAggregativeTracking])
@settings(max_examples=2)
@given(seed=SEEDS)
def test_aggregative_tracking_is_linear(team, jointly_connected, factor_per_round, kind, changes, seed):
    """Li, Yi, Xie 2022: linear for small steps, also over graphs that change (Carnevale, Camisa, Notarstefano 2023);
    here at least half as fast as centralized gradient descent."""
    step = 0.01
    problems, optimum, curvature = surveillance(4, seed)
    largest, schedule = jointly_connected(4, seed)
    agents = team(largest, problems, schedule=schedule if changes else None)
    algorithms = [kind(agent, np.zeros(DIMENSION), stepsize=step) for agent in agents]
    errors = after_each_round(algorithms, 350, lambda: np.abs(stacked(algorithms) - optimum).max())
    assert factor_per_round(errors, after=50) <= 1.0 - step * curvature / 2.0
    assert errors[-1] < 2e-2 * errors[0]


# -------------------------------------------------------------------- constraints


def constrained(size, seed):
    """Costs and half-planes of each agent, the optimum of all, and prices that make it the optimum of each agent."""
    dice = np.random.default_rng(seed)
    inside = dice.normal(size=DIMENSION)
    parts = []
    for _ in range(size):
        A = dice.normal(size=(1, DIMENSION))
        P = np.diag(dice.uniform(0.5, 1.5, DIMENSION))
        parts.append(
            QuadraticProblem(P, dice.uniform(-3, 3, DIMENSION), A=A, b=A @ inside + dice.uniform(0.05, 0.5, 1))
        )
    rows, sides = np.vstack([one.A for one in parts]), np.concatenate([one.b for one in parts])
    whole = QuadraticProblem(sum(one.P for one in parts), sum(one.q for one in parts), A=rows, b=sides)
    optimum = whole.minimize()
    # forces of the constraints that are active balance the gradient of the sum
    active = rows @ optimum > sides - 1e-7
    forces, rest = np.zeros(size), np.linalg.norm(whole.gradient(optimum))
    if active.any():
        forces[active], rest = nnls(rows[active].T, -whole.gradient(optimum))
    assert rest < 1e-6
    prices = -np.array([one.gradient(optimum) + force * one.A[0] for one, force in zip(parts, forces, strict=True)])
    return parts, optimum, prices


@settings(max_examples=5)
@given(seed=SEEDS, size=st.integers(2, 5))
def test_dual_decomposition_is_as_fast_as_gradient_ascent_of_the_dual(team, seed, size):
    """Beck, Teboulle 2009: the dual is c^2/(2 step k) short of its optimum after k rounds, and the points
    are within c/sqrt(step m k), where c is the length of the prices of all edges that are to be found."""
    parts, optimum, prices = constrained(size, seed)
    adjacency = graphs.binomial_random_graph(size, 0.6, seed)
    laplacian = np.diag(adjacency.sum(axis=1)) - adjacency
    least = min(least_curvatures(parts))
    step = least / np.linalg.eigvalsh(laplacian)[-1]
    length = np.sqrt(np.sum(prices * (np.linalg.pinv(laplacian) @ prices)))
    algorithms = [DualDecomposition(agent, stepsize=step) for agent in team(adjacency, parts)]
    distances = after_each_round(algorithms, 100, lambda: np.linalg.norm(stacked(algorithms) - optimum))
    rounds = np.arange(1, 101)
    assert np.all(np.array(distances[1:]) <= length / np.sqrt(step * least * rounds) + 1e-9)


@settings(max_examples=4)
@given(seed=SEEDS, size=st.integers(2, 4))
def test_admm_moves_less_and_less(team, seed, size):
    """Davis, Yin 2016: the k-th step of a relaxed iteration is at most the distance to where it goes, by
    the root of (k + 1)(1/relaxation - 1), and no step is longer than the one before."""
    parts, optimum, _ = constrained(size, seed)
    algorithms = [ADMM(agent, relaxation=0.5) for agent in team(graphs.binomial_random_graph(size, 0.6, seed), parts)]

    def exchanged():
        return np.concatenate([z for one in algorithms for z in one._z.values()])

    states = after_each_round(algorithms, 60, exchanged)
    run_together(algorithms, 240)
    goal = exchanged()
    np.testing.assert_allclose(stacked(algorithms), np.tile(optimum, (size, 1)), atol=1e-3)
    moved = np.linalg.norm(np.diff(states, axis=0), axis=1)
    assert np.all(moved[1:] <= moved[:-1] * (1.0 + 1e-9) + 1e-12)
    rounds = np.arange(1, len(moved) + 1)
    assert np.all(moved <= np.linalg.norm(states[0] - goal) / np.sqrt(rounds) + 1e-6)


# -------------------------------------------------------------------- finitely many rounds


@settings(max_examples=8)
@given(seed=SEEDS, size=st.integers(2, 6))
def test_the_simplex_may_stop_when_nothing_changed_for_twice_the_diameter(team, seed, size):
    """Buerger, Notarstefano, Bullo, Allgoewer 2012: finitely many rounds; an agent without changes for 2 d + 1 rounds
    has the best basis."""
    dice = np.random.default_rng(seed)
    b = dice.uniform(-2.0, 2.0, 3)
    parts = [LinearProblem(dice.uniform(0, 3, 3), dice.normal(size=(3, 3)), b) for _ in range(size)]
    adjacency = graphs.binomial_random_graph(size, 0.6, seed, "directed")
    unchanged = 2 * diameter(adjacency) + 1
    algorithms = [DistributedSimplex(agent, stop_iterations=unchanged) for agent in team(adjacency, parts)]
    assert run_together(algorithms, 200) < 200
    whole = LinearProblem(np.concatenate([one.costs for one in parts]), np.hstack([one.columns for one in parts]), b)
    central = DistributedSimplex(team(np.zeros((1, 1)), [whole])[0])
    for one in algorithms:
        np.testing.assert_allclose(one.B, central.B, atol=1e-9)


@settings(max_examples=8)
@given(seed=SEEDS, size=st.integers(2, 6))
def test_constraints_consensus_may_stop_when_nothing_changed_for_twice_the_diameter(team, seed, size):
    """Notarstefano, Bullo 2011: the cost of what an agent knows never falls, it is the optimum after finitely many
    rounds, and an agent without changes for 2 d + 1 rounds has it."""
    parts, _, _ = constrained(size, seed)
    cost = parts[0].P, parts[0].q
    parts = [QuadraticProblem(*cost, A=one.A, b=one.b) for one in parts]
    whole = QuadraticProblem(*cost, A=np.vstack([one.A for one in parts]), b=np.concatenate([one.b for one in parts]))
    adjacency = graphs.binomial_random_graph(size, 0.6, seed, "directed")
    unchanged = 2 * diameter(adjacency) + 1
    algorithms = [ConstraintsConsensus(agent, stop_iterations=unchanged) for agent in team(adjacency, parts)]
    values = []
    rounds = run_together(algorithms, 200, until=lambda: values.append([whole.value(one.x) for one in algorithms]))
    assert rounds < 200
    assert np.all(np.diff(values, axis=0) >= -1e-9)
    assert stacked(algorithms) == pytest.approx(np.tile(whole.minimize(), (size, 1)), abs=1e-8)
