import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import (
    DistributedSimplex,
    assigned_task,
    assignment_problem,
    assignments,
    graphs,
    run_together,
)

STARTS = np.array([(1.0, 1.0), (0.0, 1.5), (-1.0, 1.0), (-1.0, -1.0), (0.0, -1.5), (1.0, -1.0)])


def first_generation():
    """The tasks of the example: places, and the agents that can do each."""
    dice = np.random.RandomState(4)
    tasks = [(dice.uniform(-3.0, 3.0, 2), dice.random_sample(6) < 0.5) for _ in range(6)]
    return np.array([place for place, _ in tasks]), np.array([able for _, able in tasks])


def algorithms_for(team, adjacency, costs, able, **options):
    """Return one simplex per agent; costs and able have shape (agents, tasks)."""
    agents, tasks = costs.shape
    problems = []
    for i in range(agents):
        own = np.flatnonzero(able[i])
        problems.append(assignment_problem(i, agents, own.tolist(), costs[i, own], tasks))
    return [DistributedSimplex(agent) for agent in team(adjacency, problems, **options)]


@pytest.mark.parametrize("serialize", [False, True])
def test_first_generation_of_the_task_table(team, serialize):
    places, able = first_generation()
    costs = np.linalg.norm(places[None] - STARTS[:, None], axis=-1)
    algorithms = algorithms_for(team, graphs.binomial_random_graph(6, 0.2, 3), costs, able.T, serialize=serialize)
    run_together(algorithms, 4)
    for one in algorithms:
        assert pytest.approx(12.048675919, abs=1e-9) == one.J
        assert assignments(one, 6) == {0: 2, 1: 1, 2: 5, 3: 3, 4: 4, 5: 0}
        assert one.is_feasible
    assert [assigned_task(one, 6) for one in algorithms] == [2, 1, 5, 3, 4, 0]


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000), agents=st.integers(1, 6), tasks=st.integers(1, 6))
def test_as_many_as_possible_at_the_least_cost(team, seed, agents, tasks):
    """Any draw is valid: tasks that no agent can do, agents without tasks, different numbers of tasks and agents."""
    dice = np.random.default_rng(seed)
    costs, able = dice.uniform(0.1, 5.0, (agents, tasks)), dice.random((agents, tasks)) < 0.5
    adjacency = graphs.binomial_random_graph(agents, 0.6, seed) if agents > 1 else np.zeros((1, 1))
    algorithms = algorithms_for(team, adjacency, costs, able)
    run_together(algorithms, 4 * agents)
    rows, columns = linear_sum_assignment(np.where(able, costs, 1000.0))
    served = able[rows, columns]
    for one in algorithms:
        found = assignments(one, agents)
        assert len(found) == served.sum()
        assert all(able[i, k] for i, k in found.items())
        assert len(set(found.values())) == len(found)
        total = sum(costs[i, k] for i, k in found.items())
        assert total == pytest.approx(costs[rows, columns][served].sum())
        assert assigned_task(one, agents) == found.get(one.agent.id)


def test_losses_do_not_change_the_assignment(team, in_any_order):
    places, able = first_generation()
    costs = np.linalg.norm(places[None] - STARTS[:, None], axis=-1)
    algorithms = algorithms_for(team, graphs.binomial_random_graph(6, 0.2, 3), costs, able.T, loss=0.2)
    in_any_order(algorithms, 40)
    assert [assigned_task(one, 6) for one in algorithms] == [2, 1, 5, 3, 4, 0]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((2, 2, [0], [1.0]), "agent is 2"),
        ((0, 2, [2], [1.0]), r"\[2\], allowed: \[0, 1\]"),
        ((0, 2, [1, 1], [1.0, 1.0]), "each once"),
    ],
)
def test_bad_assignments_are_refused(arguments, says):
    with pytest.raises(RangeError, match=says):
        assignment_problem(*arguments)
