"""Cubic splines (docs/reference/crazychoir.md#7.3, #21 and #23)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning import cubic_spline

NUMBERS = {
    "go-to, with the knot in the middle that the original has": (
        ([0, 2.5, 5], [0, 0.5, 1]),
        [0, 1.25, 2.5, 3.75, 5],
        [
            [0, 0, 0, 0.042666667],
            [0.083333333, 0.2, 0.16, -0.042666667],
            [0.5, 0.4, 0, -0.042666667],
            [0.916666667, 0.2, -0.16, 0.042666667],
        ],
    ),
    "multi": (
        ([0, 1, 2, 4], [0, 0.3, 0.5, 0]),
        [0, 0.5, 1, 2, 3, 4],
        [
            [0, 0, 0, 0.427272727],
            [0.053409091, 0.320454545, 0.640909091, -0.590909091],
            [0.3, 0.518181818, -0.245454545, -0.072727273],
            [0.5, -0.190909091, -0.463636364, 0.263636364],
            [0.109090909, -0.327272727, 0.327272727, -0.109090909],
        ],
    ),
}
NUMBERS["go-to of two points"] = (
    ([0, 5], [0, 1]),
    *NUMBERS["go-to, with the knot in the middle that the original has"][1:],
)

intervals = st.lists(st.floats(0.2, 5.0), min_size=1, max_size=12)
seeds = st.integers(0, 1000)


def some_spline(intervals, seed):
    rng = np.random.default_rng(seed)
    times = np.concatenate([[1.0], 1.0 + np.cumsum(intervals)])
    points = rng.uniform(-2, 2, (len(times), 3))
    names = ("start_velocity", "start_acceleration", "end_velocity", "end_acceleration")
    boundary = {name: rng.uniform(-1, 1, 3) for name in names}
    return times, points, boundary, cubic_spline(times, points, **boundary)


@pytest.mark.parametrize("name", NUMBERS)
def test_splines_have_the_numbers_of_the_original(name):
    (times, points), knots, coefficients = NUMBERS[name]
    curve = cubic_spline(times, np.array(points, dtype=float)[:, None])
    np.testing.assert_allclose(curve.knots, knots)
    np.testing.assert_allclose(curve.coefficients[:, 0], coefficients, atol=6e-10)


def test_peak_speed_of_a_go_to_is_twice_the_mean():
    curve = cubic_spline([0, 5], [[0.0], [1.0]])
    assert curve.velocity(np.linspace(0, 5, 1001)).max() == pytest.approx(0.4)


@settings(max_examples=40)
@given(intervals, seeds)
def test_splines_go_through_all_points(intervals, seed):
    times, points, _, curve = some_spline(intervals, seed)
    np.testing.assert_allclose(curve.position(times - times[0]), points, atol=1e-8)


@settings(max_examples=40)
@given(intervals, seeds)
def test_velocity_and_acceleration_are_continuous(intervals, seed):
    *_, curve = some_spline(intervals, seed)
    inner = curve.knots[1:-1]
    for order in range(3):
        scale = 1.0 + np.abs(curve.at(inner, order)).max()
        np.testing.assert_allclose(curve.at(np.nextafter(inner, 0), order), curve.at(inner, order), atol=1e-9 * scale)


@settings(max_examples=40)
@given(intervals, seeds)
def test_boundary_values_are_met(intervals, seed):
    _, _, boundary, curve = some_spline(intervals, seed)
    found = {
        "start_velocity": curve.velocity(0.0),
        "start_acceleration": curve.acceleration(0.0),
        "end_velocity": curve.end(1),
        "end_acceleration": curve.end(2),
    }
    for name, value in boundary.items():
        np.testing.assert_allclose(found[name], value, atol=1e-8, err_msg=name)


@pytest.mark.parametrize(
    ("times", "points", "message"),
    [
        ([0.0], [[1.0]], "at least 2 points"),
        ([0.0, 1.0, 1.0], [[0.0], [1.0], [2.0]], r"times must increase, but 1 s comes after 1 s \(point 2\)"),
        ([0.0, 1.0], [[0.0], [np.nan]], "point 1 is not finite"),
        ([0.0, np.inf], [[0.0], [1.0]], "time 1 is not finite"),
        ([0.0, 1.0, 2.0], [[0.0], [1.0]], "3 times for 2 points"),
    ],
)
def test_bad_points_are_refused(times, points, message):
    with pytest.raises(RangeError, match=message):
        cubic_spline(times, points)
