"""Curves of least snap, and when to be where on them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning import (
    GENTLE,
    Limits,
    State,
    allocate_times,
    check_limits,
    minimum_snap,
    point_to_point,
    through_states,
    trapezoidal_times,
)
from crazychoir_fw.planning.curves.minimum_snap import snap_gradient

intervals = st.lists(st.floats(0.3, 3.0), min_size=1, max_size=8)
seeds = st.integers(0, 1000)


def some_waypoints(intervals, seed):
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(intervals)])
    return rng, times, rng.uniform(-2, 2, (len(times), 3))


def test_two_points_make_the_rest_to_rest_polynomial():
    expected = point_to_point(State(np.zeros(3)), State(np.ones(3)), 3.0)
    curve = minimum_snap([0.0, 3.0], [[0, 0, 0], [1, 1, 1]])
    np.testing.assert_allclose(curve.coefficients, expected.coefficients, atol=1e-12)


@settings(max_examples=25)
@given(intervals, seeds)
def test_curves_are_smooth_and_go_through_the_points(intervals, seed):
    _, times, points = some_waypoints(intervals, seed)
    curve = minimum_snap(times, points)
    np.testing.assert_allclose(curve.position(times), points, atol=1e-6)
    inner = curve.knots[1:-1]
    for order in range(7):
        scale = 1.0 + np.abs(curve.at(np.linspace(0, curve.duration, 50), order)).max()
        before = curve.at(np.nextafter(inner, 0), order)
        np.testing.assert_allclose(before, curve.at(inner, order), atol=1e-6 * scale)


@settings(max_examples=25)
@given(intervals, seeds)
def test_no_neighbor_has_less_snap(intervals, seed):
    rng, times, points = some_waypoints(intervals, seed)
    curve = minimum_snap(times, points)
    knots = [State(*values) for values in np.stack([curve.at(times, order) for order in range(4)], axis=1)]
    assert through_states(knots, times).cost() == pytest.approx(curve.cost(), rel=1e-6)
    for _ in range(5):
        others = [
            knots[0],
            *(State(k.position, *rng.normal(0, 0.1, (3, 3)) + vars_of(k)) for k in knots[1:-1]),
            knots[-1],
        ]
        assert through_states(others, times).cost() >= curve.cost() * (1 - 1e-9)


def vars_of(state):
    return np.array([state.velocity, state.acceleration, state.jerk])


@settings(max_examples=25)
@given(intervals, seeds)
def test_given_velocities_and_boundary_values_are_met(intervals, seed):
    rng, times, points = some_waypoints(intervals, seed)
    start, end = rng.uniform(-1, 1, (2, 3, 3))
    velocities = [rng.uniform(-1, 1, 3) if k % 2 else None for k in range(len(times))]
    velocities[-1] = None
    curve = minimum_snap(times, points, velocities=velocities, start=start, end=end)
    for order in range(3):
        np.testing.assert_allclose(curve.at(0.0, order + 1), start[order], atol=1e-6)
        np.testing.assert_allclose(curve.end(order + 1), end[order], atol=1e-4)
    for time, velocity in zip(times, velocities, strict=True):
        if velocity is not None:
            np.testing.assert_allclose(curve.velocity(time), velocity, atol=1e-6)


@settings(max_examples=25)
@given(intervals, seeds)
def test_gradient_of_the_least_snap(intervals, seed):
    _, times, points = some_waypoints(intervals, seed)
    durations = np.diff(times)
    cost, slopes = snap_gradient(minimum_snap(times, points))
    for k in range(len(durations)):
        ends = []
        for step in (-1e-4, 1e-4):
            changed = durations.copy()
            changed[k] *= 1 + step
            ends.append(minimum_snap(np.concatenate([[0], np.cumsum(changed)]), points).cost())
        assert (ends[1] - ends[0]) / (2e-4 * durations[k]) == pytest.approx(slopes[k], rel=1e-4, abs=1e-4 * cost)


@pytest.mark.parametrize(
    ("distance", "limits", "seconds"),
    [
        (4.0, Limits(speed=1.0, acceleration=2.0), 4.5),  # 0.5 s up, 3.5 s at 1 m/s, 0.5 s down
        (0.5, Limits(speed=1.0, acceleration=2.0), 1.0),  # just reaches it
        (0.125, Limits(speed=1.0, acceleration=2.0), 0.5),
        (2.0, Limits(acceleration=2.0), 2.0),
        (0.0, Limits(acceleration=2.0), 0.1),
    ],
)
def test_guess_is_a_trapezoid_of_speed(distance, limits, seconds):
    np.testing.assert_allclose(trapezoidal_times([[0.0], [distance]], limits), [0.0, seconds])


@settings(max_examples=15)
@given(st.integers(2, 7), seeds, st.sampled_from([GENTLE, Limits.of_platform("cf21bl", speed=3.0, acceleration=8.0)]))
def test_allocation_keeps_within_limits_and_uses_one_up(count, seed, limits):
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (count, 3))
    found = allocate_times(points, limits)
    assert found.report.holds
    assert 0.99 <= found.report.binding.share <= 1.0 + 1e-6
    assert found.curve.duration <= found.guess_duration * (1 + 1e-9)
    np.testing.assert_allclose(found.curve.position(found.times), points, atol=1e-6)
    times = np.linspace(0, found.curve.duration, 3001)
    for order, limit in ((1, limits.speed), (2, limits.acceleration)):
        assert np.linalg.norm(found.curve.at(times, order), axis=1).max() <= limit * 1.001


def test_allocation_beats_the_guess_where_there_are_corners():
    square = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 0, 1]]
    found = allocate_times(square, GENTLE)
    assert found.curve.duration < 0.85 * found.guess_duration
    assert found.report.binding.name == "speed"


def test_begin_in_flight_stays_as_it_is():
    start = [[0.5, 0, 0], [0, 0.3, 0]]
    found = allocate_times([[0, 0, 1], [1, 1, 1], [2, 0, 1]], GENTLE, start=start)
    np.testing.assert_allclose(found.curve.velocity(0.0), start[0], atol=1e-9)
    np.testing.assert_allclose(found.curve.acceleration(0.0), start[1], atol=1e-9)
    assert found.report.holds


def test_begin_beyond_a_limit_is_refused():
    with pytest.raises(RangeError, match=r"speed is [\d.]+ at .* however slowly it flies, allowed: 1"):
        allocate_times([[0, 0, 1], [1, 1, 1]], GENTLE, start=[[2.0, 0, 0]])
    loose = allocate_times([[0, 0, 1], [1, 1, 1]], GENTLE, start=[[2.0, 0, 0]], is_strict=False)
    assert not loose.report.holds
    assert check_limits(loose.curve, GENTLE).binding == loose.report.binding


def test_without_limits_there_is_no_shortest_time():
    with pytest.raises(RangeError, match="nothing is limited"):
        allocate_times([[0, 0, 0], [1, 1, 1]], Limits())
