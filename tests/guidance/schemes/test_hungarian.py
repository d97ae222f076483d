"""Best assignments against SciPy, and what the distributed simplex makes of the same costs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.guidance import Graph, InProcessTransport, TimeVaryingCommunicator
from crazychoir_fw.guidance.optimization import Agent, DistributedSimplex, assignment_problem, assignments, run_together
from crazychoir_fw.guidance.schemes.tasks.hungarian import best_assignment

scipy_optimize = pytest.importorskip("scipy.optimize")


@st.composite
def instances(draw, square=False):
    rows = draw(st.integers(1, 7))
    columns = rows if square else draw(st.integers(1, 7))
    seed = draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    costs = random.uniform(0.0, 9.0, (rows, columns))
    costs[random.random((rows, columns)) > draw(st.floats(0.2, 1.0))] = np.inf
    return costs


def by_scipy(costs):
    big = 1e4
    rows, columns = scipy_optimize.linear_sum_assignment(np.where(np.isfinite(costs), costs, big))
    pairs = [(i, j) for i, j in zip(rows, columns, strict=True) if np.isfinite(costs[i, j])]
    return len(pairs), sum(costs[pair] for pair in pairs)


@given(instances())
@settings(max_examples=60)
def test_best_assignment_is_that_of_scipy(costs):
    found = best_assignment(costs)
    count, cost = by_scipy(costs)
    assert len(found) == len(set(found.values())) == count
    assert sum(costs[pair] for pair in found.items()) == pytest.approx(cost)


@given(instances(square=True), st.integers(0, 1000))
@settings(max_examples=25)
def test_distributed_assignments_are_those_of_scipy(costs, seed):
    size = len(costs)
    graph = Graph.binomial(size, 0.4, seed) if size > 1 else Graph.undirected(1, [], ["0"])
    transport = InProcessTransport()
    algorithms = []
    for i in range(size):
        heard = graph.in_neighbors(i)
        agent = Agent(communicator=TimeVaryingCommunicator(i, size, heard, transport=transport))
        able = np.flatnonzero(np.isfinite(costs[i]))
        agent.set_problem(assignment_problem(i, size, able.tolist(), costs[i, able]))
        algorithms.append(DistributedSimplex(agent))
    run_together(algorithms, 3 * size)
    count, cost = by_scipy(costs)
    for algorithm in algorithms:
        found = assignments(algorithm, size)
        assert len(found) == count
        assert sum(costs[pair] for pair in found.items()) == pytest.approx(cost, abs=1e-6)


def test_nothing_to_assign():
    assert best_assignment(np.zeros((0, 0))) == {}
    assert best_assignment([[np.inf, np.inf]]) == {}
