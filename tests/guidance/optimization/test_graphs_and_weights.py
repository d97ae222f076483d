import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization import graphs


def edges(matrix):
    return [(i, j) for i, j in np.argwhere(np.triu(matrix)).tolist()]


def test_task_assignment_graph():
    assert edges(graphs.binomial_random_graph(6, 0.2, 3)) == [(0, 3), (1, 4), (2, 5), (3, 5), (4, 5)]


def test_aggregative_graph_and_weights():
    path = graphs.binomial_random_graph(3, 0.5, 3)
    assert edges(path) == [(0, 1), (1, 2)]
    third = 1 / 3
    np.testing.assert_allclose(
        graphs.metropolis_hastings(path), [[2 * third, third, 0], [third, third, third], [0, third, 2 * third]]
    )


def test_directed_graph_is_the_one_of_disropt():
    # drawn with disropt 0.1.9
    expected = [[0, 1, 1, 1], [0, 0, 1, 1], [1, 0, 0, 1], [0, 1, 1, 0]]
    np.testing.assert_array_equal(graphs.binomial_random_graph(4, 0.3, 1, "directed"), expected)


def test_global_generator_is_left_alone():
    np.random.seed(5)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    graphs.binomial_random_graph(6, 0.2, 3)
    graphs.binomial_random_graph(6, 0.2, 3, "directed")
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


def test_path_and_rings():
    assert edges(graphs.path_graph(3)) == [(0, 1), (1, 2)]
    assert edges(graphs.ring_graph(4)) == [(0, 1), (0, 3), (1, 2), (2, 3)]
    np.testing.assert_array_equal(graphs.ring_graph(3, "directed"), [[0, 1, 0], [0, 0, 1], [1, 0, 0]])


@given(seed=st.integers(0, 10_000), size=st.integers(2, 8))
def test_weights_are_stochastic(seed, size):
    directed = graphs.binomial_random_graph(size, 0.5, seed, "directed")
    rows, columns = graphs.row_stochastic_matrix(directed), graphs.column_stochastic_matrix(directed)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0)
    np.testing.assert_allclose(columns.sum(axis=0), 1.0)
    both = graphs.metropolis_hastings(np.maximum(directed, directed.T))
    np.testing.assert_allclose(both.sum(axis=0), 1.0)
    np.testing.assert_allclose(both, both.T)
    assert both.min() >= -1e-15
    off_diagonal = ~np.eye(size, dtype=bool)
    np.testing.assert_array_equal((rows != 0)[off_diagonal], (directed != 0)[off_diagonal])


@given(seed=st.integers(0, 10_000), period=st.integers(1, 5))
def test_each_period_of_a_sequence_holds_all_edges(seed, period):
    largest = graphs.binomial_random_graph(6, 0.4, seed)
    sequence = graphs.binomial_random_graph_sequence(largest, 3 * period, 0.2, period=period, seed=seed)
    for begin in range(0, 3 * period, period):
        np.testing.assert_array_equal(np.max(sequence[begin : begin + period], axis=0), largest)
    assert all(np.array_equal(one, one.T) for one in sequence)


def test_sequence_without_period_keeps_edges_with_their_probability():
    largest = graphs.ring_graph(10, "directed")
    sequence = graphs.binomial_random_graph_sequence(largest, 400, 0.3, seed=1, link_type="directed")
    kept = np.mean(sequence, axis=0)[largest > 0]
    np.testing.assert_allclose(kept, 0.3, atol=0.08)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: graphs.binomial_random_graph(4, 0.0, None), "p is 0.0"),
        (lambda: graphs.binomial_random_graph(9, 1e-6, 1, "directed"), "enough for a connected graph of 9"),
        (lambda: graphs.ring_graph(4, "both"), "link_type is 'both'"),
        (lambda: graphs.binomial_random_graph_sequence(np.eye(2), 3, 2.0), "p is 2.0"),
        (lambda: graphs.binomial_random_graph_sequence(np.eye(2), 3, period=0), "period is 0"),
        (lambda: graphs.metropolis_hastings(graphs.ring_graph(3, "directed")), "undirected"),
    ],
)
def test_bad_arguments_are_named(call, says):
    with pytest.raises(RangeError, match=says):
        call()
