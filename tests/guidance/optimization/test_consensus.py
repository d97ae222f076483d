import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import Consensus, MaxConsensus, PushSumConsensus, graphs, run_together

SEEDS = st.integers(0, 10_000)


def values(size, seed):
    return np.random.default_rng(seed).uniform(-5.0, 5.0, (size, 2, 3))


@settings(max_examples=15)
@given(seed=SEEDS, size=st.integers(2, 7))
def test_agents_agree_on_the_mean(team, seed, size):
    x = values(size, seed)
    algorithms = [
        Consensus(agent, one) for agent, one in zip(team(graphs.binomial_random_graph(size, 0.5, seed)), x, strict=True)
    ]
    run_together(algorithms, 400)
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), x.mean(axis=0), atol=1e-4)


@settings(max_examples=10)
@given(seed=SEEDS)
def test_agents_agree_on_the_mean_over_graphs_that_change(team, jointly_connected, seed):
    largest, schedule = jointly_connected(5, seed)
    x = values(5, seed)
    algorithms = [Consensus(agent, one) for agent, one in zip(team(largest, schedule=schedule), x, strict=True)]
    run_together(algorithms, 400)
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), x.mean(axis=0), atol=1e-4)


def test_with_losses_plain_consensus_agrees_but_not_on_the_mean(team, in_any_order):
    algorithms = [Consensus(agent, float(agent.id) ** 2) for agent in team(graphs.ring_graph(5), loss=0.2)]
    in_any_order(algorithms, 300)
    results = np.array([one.get_result() for one in algorithms])
    assert np.ptp(results) < 1e-6
    assert abs(results[0] - 6.0) > 1e-3


@settings(max_examples=10)
@given(seed=SEEDS, size=st.integers(2, 6))
def test_push_sum_finds_the_mean_with_losses_over_directed_graphs(team, in_any_order, seed, size):
    x = values(size, seed)
    agents = team(graphs.binomial_random_graph(size, 0.6, seed, "directed"), loss=0.2, seed=seed)
    algorithms = [PushSumConsensus(agent, one) for agent, one in zip(agents, x, strict=True)]
    in_any_order(algorithms, 600, seed)
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), x.mean(axis=0), atol=1e-5)


def test_push_sum_over_graphs_that_change(team, jointly_connected):
    largest, schedule = jointly_connected(5, 4)
    algorithms = [PushSumConsensus(agent, float(agent.id)) for agent in team(largest, schedule=schedule)]
    run_together(algorithms, 600)
    np.testing.assert_allclose([one.get_result() for one in algorithms], 2.0, atol=1e-6)


def test_maximum_is_known_after_the_diameter(team):
    algorithms = [MaxConsensus(agent, [agent.id, -agent.id], graph_diameter=4) for agent in team(graphs.path_graph(5))]
    assert run_together(algorithms, 100) == 4
    assert all(one.is_done and one.get_result().tolist() == [4.0, 0.0] for one in algorithms)


def test_maximum_with_losses(team, in_any_order):
    algorithms = [MaxConsensus(agent, float(agent.id)) for agent in team(graphs.ring_graph(6, "directed"), loss=0.2)]
    in_any_order(algorithms, 60)
    assert [one.get_result() for one in algorithms] == [5.0] * 6


def test_initial_values_must_be_finite(team):
    with pytest.raises(RangeError, match="initial_condition is"):
        Consensus(team(graphs.path_graph(2))[0], [np.nan])
