import sys

import numpy as np
import osqp
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.guidance.optimization import InfeasibleError, QuadraticProblem


@given(seed=st.integers(0, 10_000), n=st.integers(1, 4), m=st.integers(0, 6), k=st.integers(0, 1))
def test_minimum_is_the_one_of_another_solver(seed, n, m, k):
    dice = np.random.default_rng(seed)
    root = dice.normal(size=(n, n))
    inside = dice.normal(size=n)
    A, E = dice.normal(size=(m, n)), dice.normal(size=(k, n))
    b, f = A @ inside + dice.uniform(0.1, 1, m), E @ inside
    problem = QuadraticProblem(root @ root.T + 0.1 * np.eye(n), dice.normal(size=n), A=A, b=b, E=E, f=f)
    x = problem.minimize()
    other = osqp.OSQP()
    other.setup(
        sparse.csc_matrix(2 * problem.P),
        problem.q,
        sparse.csc_matrix(np.vstack([A, E, np.zeros((1, n))])),
        np.concatenate([np.full(m, -np.inf), f, [0.0]]),
        np.concatenate([b, f, [0.0]]),
        eps_abs=1e-9,
        eps_rel=1e-9,
        max_iter=100_000,
        polishing=True,
        verbose=False,
    )
    np.testing.assert_allclose(x, other.solve().x, atol=1e-5)
    np.testing.assert_allclose(E @ x, f, atol=1e-9)
    assert np.all(A @ x <= b + 1e-9)


def test_gradient_is_the_one_of_the_value():
    problem = QuadraticProblem([[1.0, 2.0], [0.0, 3.0]], [1.0, -1.0], 4.0)
    x, step = np.array([0.3, -0.7]), np.array([1e-6, 0.0])
    assert problem.value(x) == pytest.approx(x @ [[1.0, 2.0], [0.0, 3.0]] @ x + x[0] - x[1] + 4.0)
    assert (problem.value(x + step) - problem.value(x - step)) / 2e-6 == pytest.approx(problem.gradient(x)[0])


def test_contradictions_are_said():
    problem = QuadraticProblem([[1.0]], [0.0], A=[[1.0], [-1.0]], b=[-1.0, -1.0])
    with pytest.raises(InfeasibleError, match="no point"):
        problem.minimize()


@pytest.mark.parametrize("constraints", [{}, {"A": [[1.0, 0.0]], "b": [1.0]}])
def test_flat_costs_are_said(constraints):
    with pytest.raises(RangeError, match="flat"):
        QuadraticProblem([[1.0, 0.0], [0.0, 0.0]], [0.0, 1.0], **constraints).minimize()


def test_missing_solver_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "quadprog", None)
    with pytest.raises(StateError, match=r"pip install 'crazychoir-fw\[optimization\]'"):
        QuadraticProblem([[1.0]], [0.0], A=[[1.0]], b=[1.0]).minimize()


@pytest.mark.parametrize(
    ("arguments", "options", "says"),
    [
        (([[1.0]], [0.0, 0.0]), {}, r"P has shape \(1, 1\), allowed: \(2, 2\)"),
        (([[1.0]], [0.0]), {"A": [1.0], "b": [1.0]}, r"A has shape \(1,\)"),
        (([[-1.0]], [0.0]), {}, "negative eigenvalue"),
        (([[1.0]], [0.0]), {"A": [[1.0]]}, "only one of A and b"),
        (([[1.0]], [0.0]), {"E": [[1.0]], "f": [1.0, 2.0]}, "E has 1 rows, f has 2"),
        (([[1.0]], [0.0]), {"A": [[np.nan]], "b": [1.0]}, "finite"),
    ],
)
def test_bad_problems_are_named(arguments, options, says):
    with pytest.raises(RangeError, match=says):
        QuadraticProblem(*arguments, **options)
