"""The trajectory file of examples/figure8.yaml is what its script computes: smooth, closed, at rest at both ends."""

import runpy
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from crazychoir_fw.common.trajectory_files import end_points, read_pieces, total_duration

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def pieces():
    return read_pieces(EXAMPLES / "figure8.csv")


def derivative(piece, t, order):
    """Return the *order*-th derivative of x, y, z and yaw at time t (s) of a piece, shape (4,)."""
    axes = piece[:32].reshape(4, 8).astype(float)
    return np.array([np.polynomial.Polynomial(axis).deriv(order)(t) for axis in axes])


def test_file_is_what_the_script_computes(pieces):
    computed = runpy.run_path(str(EXAMPLES / "make_figure8.py"))["pieces"]()
    np.testing.assert_allclose(pieces, computed, atol=2e-6)


def test_path_is_closed_and_at_rest_at_both_ends(pieces):
    first, last = end_points(pieces)
    np.testing.assert_allclose(first, 0.0, atol=1e-5)
    np.testing.assert_allclose(last, 0.0, atol=1e-5)
    for order in (1, 2, 3):
        np.testing.assert_allclose(derivative(pieces[0], 0.0, order), 0.0, atol=1e-4)
        np.testing.assert_allclose(derivative(pieces[-1], float(pieces[-1, 32]), order), 0.0, atol=1e-3)


@pytest.mark.parametrize(("order", "tolerance"), [(0, 1e-5), (1, 2e-5), (2, 1e-4), (3, 5e-4)])
def test_joints_are_smooth_up_to_the_jerk(pieces, order, tolerance):
    for before, after in pairwise(pieces):
        gap = derivative(before, float(before[32]), order) - derivative(after, 0.0, order)
        assert np.abs(gap).max() < tolerance


def test_path_is_two_by_one_meter_and_gentle(pieces):
    samples = [(piece, t) for piece in pieces for t in np.linspace(0.0, float(piece[32]), 40)]
    path = np.array([derivative(piece, t, 0) for piece, t in samples])
    speed = np.linalg.norm([derivative(piece, t, 1) for piece, t in samples], axis=1)
    assert np.ptp(path[:, 0]) == pytest.approx(2.0, abs=0.01)
    assert np.ptp(path[:, 1]) == pytest.approx(1.0, abs=0.01)
    assert speed.max() == pytest.approx(1.131, abs=0.001)
    assert total_duration(pieces) == pytest.approx(9.854, abs=0.001)
