"""Graphs, their checks, and how they change."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import Graph, RandomEdges, TimedGraphs, WithinDistance


def test_binomial_graphs_are_the_originals():
    assert Graph.binomial(6, 0.2, 3).pairs == ((0, 3), (1, 4), (2, 5), (3, 5), (4, 5))
    assert Graph.binomial(3, 0.5, 3) == Graph.path(3)


def test_metropolis_hastings_weights_are_the_originals():
    weights = Graph.binomial(3, 0.5, 3).metropolis_hastings()
    np.testing.assert_allclose(weights, np.array([[2, 1, 0], [1, 1, 1], [0, 1, 2]]) / 3.0)


@given(st.integers(2, 12), st.floats(0.2, 1.0), st.integers(0, 1000))
def test_random_graphs_are_connected_and_their_weights_doubly_stochastic(size, probability, seed):
    graph = Graph.binomial(size, probability, seed)
    assert graph.is_connected() and graph.is_undirected
    weights = graph.metropolis_hastings()
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert (weights >= -1e-12).all() and Graph.from_adjacency(graph.adjacency) == graph


def test_the_global_generator_is_left_alone():
    np.random.seed(1)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    Graph.binomial(5, 0.4, 3)
    assert (np.random.get_state()[1] == before).all()  # noqa: NPY002


def test_directed_edges_go_from_sender_to_receiver():
    graph = Graph.directed(3, [(0, 1), (1, 2)])
    assert graph.in_neighbors(1) == (0,) and graph.out_neighbors(1) == (2,)
    assert not graph.is_connected() and not graph.is_undirected
    assert graph.reachable([0]) == {0, 1, 2} and graph.reachable([2]) == {2}
    assert Graph.ring(4, directed=True).is_connected()


def test_agents_may_have_names():
    graph = Graph.undirected(3, [("a", "b"), ("b", "c")], ["a", "b", "c"])
    assert graph.pairs == ((0, 1), (1, 2)) and graph.name(2) == "c"


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Graph.undirected(3, [(0, 3)]), "names 3, allowed: 0 to 2"),
        (lambda: Graph.undirected(3, [("a", "x")], ["a", "b", "c"]), "names 'x', allowed: a, b, c"),
        (lambda: Graph.undirected(3, [(1, 1)]), "from an agent to itself"),
        (lambda: Graph.undirected(3, [(1, 2, 0)]), "no pair"),
        (lambda: Graph.undirected(3, ["01"]), "no pair"),
        (lambda: Graph.undirected(3, [(True, 0)]), "names True"),
        (lambda: Graph.undirected(0, []), "size is 0"),
        (lambda: Graph.undirected(2, [], ["a"]), "1 names"),
        (lambda: Graph.binomial(20, 0.001, 1), "probability"),
        (lambda: Graph.directed(2, [(0, 1)]).metropolis_hastings(), "one direction"),
        (lambda: Graph.directed(3, [(0, 1), (1, 0)], ["a", "b", "c"]).check_rooted([0]), "from a leader to c,"),
        (lambda: Graph.directed(3, [(0, 1), (1, 0)], ["a", "b", "c"]).check_connected(), "c is not reached from a"),
        (lambda: Graph.directed(2, [(0, 1)]).check_connected(), "agent_1 does not reach agent_0"),
    ],
)
def test_bad_graphs_are_named(make, words):
    with pytest.raises(RangeError, match=words):
        make()


def test_graphs_by_time():
    first, second = Graph.path(3), Graph.complete(3)
    once, again = TimedGraphs([(0.0, first), (2.0, second)]), TimedGraphs([(0.0, first), (2.0, second)], period=3.0)
    assert [once.graph_at(t) == second for t in (-1.0, 1.9, 2.0, 50.0)] == [False, False, True, True]
    assert [again.graph_at(t) == second for t in (1.9, 2.5, 3.5, 5.5)] == [False, True, False, True]
    assert once.neighbors_at(0, 2.5, 7) == ((1, 2), (1, 2))
    with pytest.raises(RangeError):
        TimedGraphs([(1.0, first), (0.0, second)])


def test_both_ends_of_a_random_edge_agree_without_a_word():
    whole = Graph.complete(6)
    mine, yours = (RandomEdges(whole, 0.8, seed=4, rounds=3) for _ in range(2))
    kept = 0
    for label in range(90):
        graph = mine.graph_at(label)
        assert graph.is_undirected and graph == yours.graph_at(label)
        assert graph == mine.graph_at(label - label % 3)
        kept += len(graph.pairs)
    assert 0.75 < kept / (90 * 15) < 0.85
    assert any(
        RandomEdges(whole, 0.8, seed=5).graph_at(k) != RandomEdges(whole, 0.8, seed=4).graph_at(k) for k in range(3)
    )


def test_neighbors_within_a_distance():
    places = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (3.0, 0.0, 0.0)])
    near = WithinDistance(Graph.complete(3), 1.5, lambda: places)
    assert near.neighbors_at(1, 0.0, 0) == ((0,), (0,))
    places[2, 0] = 2.0
    assert near.neighbors_at(1, 0.0, 0) == ((0, 2), (0, 2))
