import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from crazychoir_fw.guidance.optimization import UnboundedError
from crazychoir_fw.guidance.optimization.lexicographic import distinct, solve


def start(m, big_M=500.0):
    return np.vstack([np.full(m, big_M), np.eye(m)])


@given(seed=st.integers(0, 10_000), m=st.integers(1, 5), n=st.integers(0, 10))
def test_cost_is_the_one_of_a_central_solver(seed, m, n):
    dice = np.random.default_rng(seed)
    columns = np.vstack([dice.integers(0, 5, n), dice.integers(-1, 3, (m, n))]).astype(float)
    b = dice.integers(0, 4, m).astype(float)
    everything = np.hstack([columns, start(m)])
    central = linprog(everything[0], A_eq=everything[1:], b_eq=b)
    best = solve(columns, b, start(m))
    assert best.cost == pytest.approx(central.fun, abs=1e-6)
    np.testing.assert_allclose(best.basis[1:] @ best.x, b, atol=1e-8)
    assert best.x.min() >= -1e-9
    assert best.prices @ b == pytest.approx(best.cost, abs=1e-6)


@given(seed=st.integers(0, 10_000))
def test_basis_depends_on_the_columns_only(seed):
    """Many solutions are equally good: order, copies and where one starts must not matter."""
    dice = np.random.default_rng(seed)
    m, n = 4, 9
    columns = np.vstack([np.ones(n), dice.integers(0, 2, (m, n))]).astype(float)
    b = np.ones(m)
    first = solve(columns, b, start(m))
    shuffled = columns[:, dice.integers(0, n, 4 * n)]
    shuffled = np.hstack([shuffled, columns[:, dice.permutation(n)]])
    halfway = solve(columns[:, : n // 2], b, start(m))
    second = solve(np.hstack([shuffled, start(m)]), b, halfway.basis)
    np.testing.assert_array_equal(first.basis, second.basis)


def test_no_least_cost_is_said():
    with pytest.raises(UnboundedError, match="no least value"):
        solve(np.array([[-1.0], [0.0]]), np.array([1.0]), start(1))


def test_columns_are_sorted_and_distinct():
    columns = np.array([[1.0, 0.0, 1.0, -0.0], [2.0, 1.0, 2.0, 1.0]])
    np.testing.assert_array_equal(distinct(columns), [[0.0, 1.0], [1.0, 2.0]])
