"""Handlers: from points to references (docs/reference/crazychoir.md#7.1, #7.3 and #21)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.planning import (
    GENTLE,
    AccelerationTrajHandler,
    FullStateTrajHandler,
    MinimumSnap,
    Polynomial7th,
    Spline,
    SplinePosition,
    check_limits,
    fit_drawn,
)

HANDLERS = [Polynomial7th, Spline, SplinePosition, MinimumSnap, AccelerationTrajHandler, FullStateTrajHandler]
FULL = [Polynomial7th, Spline, MinimumSnap, FullStateTrajHandler]
HOME = np.array([0.5, -0.5, 1.0])


def point(time, *position, velocity=(0.0, 0.0, 0.0)):
    return TrajectoryPoint(time, np.array(position, dtype=float), np.array(velocity, dtype=float))


def flying(handler, *points, now=0.0, **pose):
    handler.set_trajectory(points, Pose(**{"position": HOME, **pose}), now)
    return handler


@pytest.mark.parametrize("make", HANDLERS)
@pytest.mark.parametrize("now", [0.0, 1e-9, 1234.5])
def test_references_start_at_the_drone_at_the_first_instant(make, now):
    handler = make()
    assert handler.evaluate(now) is None
    assert not handler.is_active(now)
    flying(handler, point(2.5, 1, 2, 1), now=now)
    reference = handler.evaluate(now)
    if handler.kind == "acceleration":
        np.testing.assert_allclose(reference.acceleration, 0.0, atol=1e-12)
        assert reference.position is None
    else:
        np.testing.assert_allclose(reference.position, HOME, atol=1e-12)
        assert (reference.velocity is None) == (handler.kind == "position")
    # time that stands still
    assert handler.is_active(now)
    np.testing.assert_array_equal(str(handler.evaluate(now)), str(reference))


@pytest.mark.parametrize(
    ("make", "kind"),
    [(Spline, "fullstate"), (SplinePosition, "position"), (AccelerationTrajHandler, "acceleration")],
)
def test_topics_are_named_after_the_kind(make, kind):
    assert make().kind == make().input_topic == kind
    assert make(50.0, "goal").input_topic == "goal"
    assert make(50.0).update_frequency == 50.0


@pytest.mark.parametrize("make", FULL)
def test_the_end_is_reached_after_fractions_of_seconds_and_held(make):
    handler = flying(make(), point(2.5, 1, 2, 1), now=10.0)
    assert handler.is_active(12.5)
    assert not handler.is_active(12.501)
    for now in (12.5, 12.6, 1000.0):
        reference = handler.evaluate(now)
        np.testing.assert_allclose(reference.position, [1, 2, 1], atol=1e-9)
        np.testing.assert_allclose(reference.velocity, 0.0, atol=1e-9)
        np.testing.assert_allclose(reference.acceleration, 0.0, atol=1e-9)
    np.testing.assert_array_equal(reference.jerk, np.zeros(3))


def test_a_velocity_at_the_end_is_reached_but_not_held():
    handler = flying(Spline(), point(2.0, 1, 2, 1, velocity=(0.3, 0, 0)))
    np.testing.assert_allclose(handler.evaluate(2.0).velocity, [0.3, 0, 0], atol=1e-9)
    np.testing.assert_array_equal(handler.evaluate(2.01).velocity, np.zeros(3))


@pytest.mark.parametrize("make", FULL)
def test_paths_go_through_absolute_points_at_their_times(make):
    path = [point(1.5, 1, 2, 1), point(2.25, 0, 1, 0.5), point(4.0, -1, 0, 1.5)]
    for points in (path, [point(0.0, 9, 9, 9), *path]):
        handler = flying(make(), *points, now=7.0)
        np.testing.assert_allclose(handler.evaluate(7.0).position, HOME, atol=1e-9)
        for each in path:
            np.testing.assert_allclose(handler.evaluate(7.0 + each.time_s).position, each.position, atol=1e-9)


def test_relative_points_are_offsets():
    handler = flying(Spline(relative=True), point(1.0, 0.1, 0.2, 0.3), point(2.0, -0.1, 0, 0))
    np.testing.assert_allclose(handler.evaluate(1.0).position, HOME + np.array([0.1, 0.2, 0.3]), atol=1e-9)
    np.testing.assert_allclose(handler.evaluate(2.0).position, HOME - [0.1, 0, 0], atol=1e-9)


def test_legacy_splines_are_mirrored_at_the_present_height():
    drawn = [point(0.0, 7, 7, 7), point(1.0, 0.1, 0.2, 0.3), point(2.0, -0.1, 0, 5)]
    handler = flying(Spline(legacy=True), *drawn)
    np.testing.assert_allclose(handler.evaluate(0.0).position, HOME, atol=1e-12)
    np.testing.assert_allclose(handler.evaluate(1.0).position, HOME - [0.1, 0.2, 0], atol=1e-9)
    np.testing.assert_allclose(handler.evaluate(2.0).position, HOME + np.array([0.1, 0, 0]), atol=1e-9)


@pytest.mark.parametrize("legacy", [True, False])
def test_velocity_of_the_drone_counts_except_in_legacy_splines(legacy):
    handler = flying(Spline(legacy=legacy), point(2.0, 1, 1, 1), velocity=np.array([0.4, 0, 0]))
    np.testing.assert_allclose(handler.evaluate(0.0).velocity, [0 if legacy else 0.4, 0, 0], atol=1e-12)


def test_legacy_go_to_is_the_spline_of_the_original():
    legacy, ours = (flying(Spline(legacy=legacy), point(5.0, 1, 2, 3)) for legacy in (True, False))
    for now in np.linspace(0, 5, 21):
        np.testing.assert_allclose(legacy.evaluate(now).position, ours.evaluate(now).position, atol=1e-12)


def test_legacy_polynomial_knows_only_the_last_point():
    handler = flying(Polynomial7th(legacy=True), point(1.0, 9, 9, 9), point(4.0, 1, 1, 1))
    np.testing.assert_allclose(handler.evaluate(2.0).position, (HOME + 1.0) / 2, atol=1e-9)
    np.testing.assert_allclose(handler.evaluate(4.0).position, [1, 1, 1], atol=1e-9)


@pytest.mark.parametrize("make", FULL)
@settings(max_examples=25)
@given(elapsed=st.floats(0.0, 6.0), seed=st.integers(0, 100))
def test_planning_anew_in_flight_is_smooth(make, elapsed, seed):
    rng = np.random.default_rng(seed)
    handler = flying(make(), point(2.0, *rng.uniform(-1, 1, 3)), point(4.0, *rng.uniform(-1, 1, 3)))
    before = handler.evaluate(elapsed)
    near = before.position + rng.uniform(-0.1, 0.1, 3)
    handler.set_trajectory([point(1.5, *rng.uniform(-1, 1, 3))], Pose(near, velocity=np.ones(3)), elapsed)
    after = handler.evaluate(elapsed)
    for name in ("position", "velocity", "acceleration"):
        np.testing.assert_allclose(getattr(after, name), getattr(before, name), atol=1e-9)


def test_a_drone_that_is_elsewhere_starts_from_its_pose():
    handler = flying(Spline(), point(2.0, 1, 1, 1))
    far = handler.evaluate(1.0).position + np.array([0.31, 0, 0])
    handler.set_trajectory([point(2.0, 0, 0, 1)], Pose(far, velocity=np.array([0, 0.2, 0])), 1.0)
    np.testing.assert_allclose(handler.evaluate(1.0).position, far)
    np.testing.assert_allclose(handler.evaluate(1.0).velocity, [0, 0.2, 0], atol=1e-12)


def test_planning_needs_a_position_unless_there_is_a_reference():
    handler = Spline()
    with pytest.raises(StateError, match="Spline: the position of the drone is not known yet"):
        handler.set_trajectory([point(1.0, 0, 0, 1)], Pose(), 0.0)
    flying(handler, point(1.0, 0, 0, 1)).set_trajectory([point(1.0, 1, 0, 1)], Pose(), 0.5)
    assert handler.is_active(1.5)


def test_a_clock_that_jumps_back_ends_the_trajectory():
    handler = flying(Spline(), point(5.0, 1, 1, 1), now=100.0)
    assert handler.evaluate(103.0) is not None
    # a clock that is set by a little goes on
    assert handler.evaluate(102.9) is not None
    assert handler.evaluate(0.0) is None
    assert not handler.is_active(0.01)
    flying(handler, point(5.0, 1, 1, 1), now=0.02)
    np.testing.assert_allclose(handler.evaluate(0.02).position, HOME)


def test_points_after_a_reset_start_from_the_pose():
    handler = flying(Spline(), point(5.0, 1, 1, 1), now=100.0)
    handler.evaluate(102.0)
    handler.set_trajectory([point(1.0, 0, 0, 1)], Pose(HOME), 0.0)
    np.testing.assert_allclose(handler.evaluate(0.0).position, HOME)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], "without points"),
        ([point(0.0, 1, 1, 1)], "point 0 is at 0 s, allowed: after 0 s"),
        ([point(-1.0, 1, 1, 1)], "point 0 is at -1 s"),
        ([point(1.0, 1, 1, 1), point(1.0, 2, 2, 2)], "point 1 is at 1 s, allowed: after 1 s"),
        ([point(np.nan, 1, 1, 1)], "point 0 is at nan s"),
        ([point(1.0, 1, np.inf, 1)], "point 0: position is .*three finite numbers"),
        ([point(1.0, 1, 1)], "point 0: position is"),
        ([point(1.0, 1, 1, 1, velocity=(np.nan, 0, 0))], "point 0: velocity is"),
    ],
)
def test_bad_messages_are_refused_and_change_nothing(points, message):
    handler = flying(Spline(), point(2.0, 1, 1, 1))
    before = handler.trajectory
    with pytest.raises(RangeError, match=message):
        handler.set_trajectory(points, Pose(HOME), 1.0)
    assert handler.trajectory is before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"update_frequency": 0.0}, "update_frequency is 0"),
        ({"yaw": "north"}, "yaw is 'north'"),
        ({"times": "now"}, "times is"),
    ],
)
def test_bad_options_are_refused(options, message):
    with pytest.raises(RangeError, match=f"MinimumSnap: {message}"):
        MinimumSnap(**options)


@pytest.mark.parametrize("make", FULL)
def test_limits_slow_the_curve_down(make):
    handler = flying(make(limits=GENTLE), point(0.5, 1, 1, 1), point(1.0, 1, 0, 1.5))
    assert handler.report.holds
    assert handler.report.binding.share == pytest.approx(1.0, abs=0.01)
    assert handler.trajectory.duration > 2.0
    np.testing.assert_allclose(handler.evaluate(60.0).position, [1, 0, 1.5], atol=1e-9)


def test_limits_do_not_change_how_a_curve_begins_in_flight():
    handler = flying(Spline(limits=GENTLE), point(0.5, 3, 0, 1))
    before = handler.evaluate(1.0)
    handler.set_trajectory([point(0.5, 0, 2, 1)], Pose(before.position), 1.0)
    np.testing.assert_allclose(handler.evaluate(1.0).velocity, before.velocity, atol=1e-9)
    assert handler.evaluate(1.0).velocity[0] > 0.2


def test_free_times_are_found_within_limits():
    handler = flying(MinimumSnap(times="free"), point(0.0, 1, 0, 1), point(0.0, 1, 1, 1))
    assert handler.report.holds
    curve = handler.trajectory.curve
    np.testing.assert_allclose(curve.position(curve.knots), [HOME, [1, 0, 1], [1, 1, 1]], atol=1e-9)
    assert check_limits(curve, GENTLE).binding.share == pytest.approx(1.0, abs=0.01)


def test_minimum_snap_stops_only_where_it_is_told_to_go_on_otherwise():
    passing = flying(MinimumSnap(), point(1, 1, 0, 1, velocity=(0, 0.5, 0)), point(2, 2, 0, 1), point(3, 3, 0, 1))
    np.testing.assert_allclose(passing.evaluate(1.0).velocity, [0, 0.5, 0], atol=1e-9)
    assert passing.evaluate(2.0).velocity[0] > 0.5


def test_drawn_curves_are_followed_as_they_are():
    angles = np.linspace(0, 2 * np.pi, 100)
    curve = fit_drawn(np.stack([np.cos(angles), np.sin(angles), 1 + 0 * angles], axis=1), 4 * angles).curve
    handler = Spline()
    handler.set_curve(curve, 3.0)
    np.testing.assert_allclose(handler.evaluate(5.0).position, curve.position(2.0))
    assert handler.is_active(3.0 + curve.duration)


def test_yaw_is_held_as_it_was():
    orientation = quaternion_xyzw(np.array([0.1, -0.1, 0.7]))
    handler = flying(Spline(), point(2.0, 1, 1, 1), orientation=orientation)
    assert handler.evaluate(1.0).yaw == pytest.approx(0.7)
    assert handler.evaluate(1.0).yaw_rate == 0.0
    # it is the reference that is held, not what the drone made of it
    handler.set_trajectory([point(1.0, 0, 0, 1)], Pose(handler.evaluate(1.0).position), 1.0)
    assert handler.evaluate(9.0).yaw == pytest.approx(0.7)


def test_yaw_is_given_or_zero_in_the_original():
    orientation = quaternion_xyzw(np.array([0.0, 0.0, 0.7]))
    for options, yaw in (({"yaw": 1.2}, 1.2), ({"legacy": True}, 0.0)):
        assert flying(Spline(**options), point(2.0, 1, 1, 1), orientation=orientation).evaluate(1.0).yaw == yaw


def test_yaw_follows_the_path():
    handler = flying(MinimumSnap(yaw="path"), point(4.0, 2.5, -0.5, 1), point(8.0, 2.5, 1.5, 1))
    assert handler.evaluate(0.0).yaw == pytest.approx(0.0)
    for now in np.arange(2.0, 7.5, 0.1):
        reference = handler.evaluate(now)
        vx, vy, _ = reference.velocity
        assert reference.yaw == pytest.approx(np.arctan2(vy, vx), abs=0.1)
        rate = (handler.evaluate(now + 1e-3).yaw - reference.yaw) / 1e-3
        assert reference.yaw_rate == pytest.approx(rate, abs=0.1)
    assert handler.evaluate(100.0).yaw_rate == 0.0
