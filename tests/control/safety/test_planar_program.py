import numpy as np
import pytest
import quadprog
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.control.safety.planar_program import nearest


def reference(desired, A, b, limit):
    try:
        rows = np.vstack([-A, -np.eye(2), np.eye(2)])
        right = np.concatenate([-b, np.full(4, -limit)])
        return quadprog.solve_qp(np.eye(2), desired, rows.T.copy(), right)[0]
    except ValueError:
        return None


@given(
    seed=st.integers(0, 100_000),
    rows=st.integers(0, 8),
    scale=st.sampled_from([0.05, 0.3, 1.0]),
    limit=st.sampled_from([0.1, 1.0, 3.0]),
)
def test_solution_is_the_one_of_another_solver(seed, rows, scale, limit):
    dice = np.random.default_rng(seed)
    agents = 6
    desired, A = dice.normal(size=(agents, 2)), dice.normal(size=(agents, rows, 2))
    b = scale * dice.normal(size=(agents, rows))
    solution, found = nearest(desired, A, b, np.full(agents, limit))
    for i in range(agents):
        other = reference(desired[i], A[i], b[i], limit)
        assert found[i] == (other is not None)
        if found[i]:
            np.testing.assert_allclose(solution[i], other, atol=1e-9)
            assert np.all(A[i] @ solution[i] <= b[i] + 1e-9)
        else:
            assert np.isnan(solution[i]).all()


def test_a_corner_of_the_square_is_a_solution():
    solution, found = nearest(np.array([[5.0, 7.0]]), np.array([[[1.0, 1.0]]]), np.array([[9.0]]), 1.0)
    assert found.all()
    np.testing.assert_array_equal(solution, [[1.0, 1.0]])


def test_rows_that_are_none_do_not_count():
    A = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]])
    solution, found = nearest(np.array([[0.5, 0.2]]), A, np.array([[np.inf, 0.1, 0.0]]), 1.0)
    assert found.all()
    np.testing.assert_allclose(solution, [[0.1, 0.2]])


@pytest.mark.parametrize(
    ("A", "b"),
    [
        ([[0.0, 0.0]], [-1.0]),
        ([[1.0, 0.0], [-1.0, 0.0]], [-0.1, -0.1]),
        ([[1.0, 0.0]], [-2.0]),
    ],
    ids=["zero row", "opposite", "outside of the square"],
)
def test_there_may_be_no_solution(A, b):
    assert not nearest(np.zeros((1, 2)), np.array([A]), np.array([b]), 1.0)[1].any()


def test_what_is_no_number_stays_none():
    solution, found = nearest(np.array([[np.nan, 0.2]]), np.array([[[1.0, 0.0]]]), np.array([[0.1]]), 1.0)
    assert found.all()
    assert np.isnan(solution[0, 0])
