"""The root of a covariance, also where rounding has left none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crazychoir_fw._core import ffi, lib


def root(covariance):
    lower = ffi.new("float[9][9]")
    lib.cf_cholesky(lower, ffi.new("float[9][9]", covariance.tolist()))
    return np.array([list(row) for row in lower])


@given(arrays(float, (9, 9), elements=st.floats(-3, 3)), st.floats(0.1, 10.0))
def test_root_of_a_covariance(factor, extra):
    covariance = factor @ factor.T + extra * np.eye(9)
    assert root(covariance) == pytest.approx(np.linalg.cholesky(covariance), rel=1e-3, abs=1e-3)


def test_a_direction_that_is_not_positive_is_left_alone():
    covariance = np.diag([4.0, 1.0, -1e-3, 9.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    covariance[4, 2] = covariance[2, 4] = 0.5
    expected = np.diag([2.0, 1.0, 1e-4, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    assert root(covariance) == pytest.approx(expected, rel=1e-6)


@given(arrays(np.float32, (9, 9), elements=st.floats(-100, 100, width=32)))
def test_every_root_is_finite(matrix):
    symmetric = (matrix + matrix.T) / 2
    np.fill_diagonal(symmetric, np.abs(np.diag(symmetric)))
    assert np.all(np.isfinite(np.diag(root(symmetric))))
