"""Curves as values, and degree 7 from point to point (docs/reference/crazychoir.md#7.2 and #23)."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning import Polynomial, State, point_to_point, through_states

vectors = arrays(float, 3, elements=st.floats(-5.0, 5.0))
states = st.builds(State, vectors, vectors, vectors, vectors)
durations = st.floats(0.3, 20.0)


@pytest.mark.parametrize(
    ("power", "values"),
    [
        (4, (0.10546875, 0.2734375, 0.068359375)),
        (5, (-0.064453125, -0.1640625, -0.041015625)),
        (6, (0.013574219, 0.034179688, 0.008544922)),
        (7, (-0.000976562, -0.002441406, -0.000610352)),
    ],
)
def test_degree_7_has_the_numbers_of_the_original(power, values):
    start = State(np.zeros(3), np.array([0.1, 0.0, 0.0]))
    curve = point_to_point(start, State(np.array([1.0, 2.0, 0.5])), 4.0)
    np.testing.assert_allclose(curve.coefficients[0, :, power], values, atol=5e-10)
    np.testing.assert_allclose(curve.position(2.0), [0.56875, 1.0, 0.25], atol=1e-12)


@settings(max_examples=40)
@given(states, states, durations)
def test_degree_7_meets_all_boundary_values(start, end, duration):
    curve = point_to_point(start, end, duration)
    for order, (first, last) in enumerate(zip(vars(start).values(), vars(end).values(), strict=True)):
        scale = 1.0 / min(duration, 1.0) ** 7
        np.testing.assert_allclose(curve.at(0.0, order), first, atol=1e-9 * scale)
        np.testing.assert_allclose(curve.end(order), last, atol=1e-6 * scale)


@settings(max_examples=40)
@given(st.lists(states, min_size=2, max_size=5), durations)
def test_pieces_through_states_join_up_to_the_jerk(knots, duration):
    curve = through_states(knots, np.arange(len(knots)) * duration)
    for order, name in enumerate(("position", "velocity", "acceleration", "jerk")):
        expected = [getattr(state, name) for state in knots]
        np.testing.assert_allclose(curve.at(curve.knots, order)[:-1], expected[:-1], atol=1e-9)
        just_before = curve.at(np.nextafter(curve.knots[1:], 0.0), order)
        np.testing.assert_allclose(just_before, expected[1:], atol=1e-6 / min(duration, 1.0) ** 7)


@settings(max_examples=40)
@given(states, states, durations, st.floats(0.2, 5.0), st.floats(0.0, 1.0))
def test_derivatives_fall_by_powers_of_the_time_scale(start, end, duration, factor, place):
    curve = point_to_point(start, end, duration)
    slow = curve.stretched(factor)
    assert slow.duration == pytest.approx(factor * duration)
    for order in range(5):
        expected = curve.at(place * duration, order) / factor**order
        atol = 1e-9 * (1.0 + np.abs(slow.at(np.linspace(0, slow.duration, 20), order)).max())
        np.testing.assert_allclose(slow.at(place * slow.duration, order), expected, atol=atol)
    assert slow.cost() == pytest.approx(curve.cost() / factor**7, rel=1e-9)


def test_many_times_are_evaluated_like_one():
    curve = through_states([State(np.full(3, k)) for k in (0.0, 1.0, -1.0)], [0.0, 1.0, 3.0])
    times = np.linspace(-0.5, 3.5, 33).reshape(3, 11)
    for order in range(4):
        values = curve.at(times, order)
        assert values.shape == (3, 11, 3)
        for index, time in np.ndenumerate(times):
            np.testing.assert_allclose(values[index], curve.flat(time)[order], atol=1e-12)
    np.testing.assert_array_equal(curve.position([-7.0, 9.0]), [[0.0] * 3, [-1.0] * 3])


def test_each_derivative_is_the_slope_of_the_one_below():
    curve = through_states([State(np.full(3, k)) for k in (0.0, 1.0, -1.0)], [0.0, 1.0, 3.0])
    names = ("position", "velocity", "acceleration", "jerk", "snap")
    for lower, upper in pairwise(names):
        slope = (getattr(curve, lower)(0.7 + 1e-5) - getattr(curve, lower)(0.7 - 1e-5)) / 2e-5
        np.testing.assert_allclose(getattr(curve, upper)(0.7), slope, rtol=1e-6)


def test_cost_is_the_integral_of_squared_snap():
    curve = point_to_point(State(np.zeros(3)), State(np.ones(3)), 2.0)
    times = np.linspace(0.0, 2.0, 20001)
    squared = (curve.snap(times) ** 2).sum(axis=1)
    assert curve.cost() == pytest.approx(((squared[1:] + squared[:-1]) / 2).sum() * 1e-4, rel=1e-6)
    assert curve.cost(order=8) == 0.0


def test_a_curve_is_never_changed():
    coefficients = np.ones((1, 3, 4))
    curve = Polynomial([1.0], coefficients)
    coefficients[:] = 7.0
    np.testing.assert_array_equal(curve.position(0.0), [1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="read-only"):
        curve.coefficients[0, 0, 0] = 3.0


@pytest.mark.parametrize(
    ("durations", "coefficients"),
    [
        ([], np.ones((0, 3, 8))),
        ([1.0, 1.0], np.ones((1, 3, 8))),
        ([0.0], np.ones((1, 3, 8))),
        ([1.0], np.full((1, 3, 8), np.nan)),
    ],
)
def test_bad_pieces_are_refused(durations, coefficients):
    with pytest.raises(RangeError, match="Polynomial: .*allowed"):
        Polynomial(durations, coefficients)


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf])
def test_bad_durations_are_refused(duration):
    with pytest.raises(RangeError, match="above 0 s"):
        point_to_point(State(np.zeros(3)), State(np.ones(3)), duration)
