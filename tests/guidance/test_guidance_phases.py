"""Buttons and phases of guidance without neighbors."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import CFGuidance, GoToGuidance, Phase, SimpleDIControl, SimpleGuidance, TargetListGuidance


def at(x, y, z):
    return Pose(position=np.array([x, y, z]), velocity=np.zeros(3))


def test_before_takeoff_nothing_is_asked_for():
    guidance = SimpleGuidance(init_pos=(0.0, 0.0, 0.0))
    assert guidance.phase is Phase.IDLE
    out = guidance.step(0.0)
    assert out.idle and out.reference is None and out.trajectory is None


def test_takeoff_and_landing_are_one_point_each():
    guidance = SimpleGuidance(takeoff_time=2.5, height=0.8, init_pos=(0.3, -0.2, 0.015), agent_id=4)
    guidance.takeoff(1.0)
    out = guidance.step(1.0)
    (point,) = out.trajectory
    assert point.time_s == 2.5 and not out.idle
    np.testing.assert_allclose(point.position, (0.3, -0.2, 0.8))
    assert guidance.step(1.01).trajectory is None
    guidance.set_pose(at(0.5, 0.6, 0.8))
    guidance.land(10.0)
    (point,) = guidance.step(10.0).trajectory
    np.testing.assert_allclose(point.position, (0.5, 0.6, 0.01))
    assert not guidance.step(13.0).idle
    assert guidance.step(13.6).idle and guidance.phase is Phase.IDLE


def test_without_a_start_the_pose_at_the_takeoff_counts():
    guidance = SimpleGuidance()
    with pytest.raises(RangeError, match="neither a pose nor init_pos"):
        guidance.takeoff(0.0)
    guidance.set_pose(at(1.0, 2.0, 0.0))
    guidance.takeoff(0.0)
    np.testing.assert_allclose(guidance.step(0.0).trajectory[0].position, (1.0, 2.0, 1.0))


@pytest.mark.parametrize("kind", [SimpleGuidance, GoToGuidance])
@pytest.mark.parametrize(
    ("place", "above"), [((1.5, -2.0), (1.5, -2.0)), ((0.06, 0.0), (0.06, 0.0)), ((0.04, 0.0), (0, 0))]
)
def test_who_stands_elsewhere_climbs_straight_up(kind, place, above):
    """And not to above its start: others may stand on the way, or there."""
    guidance = kind(init_pos=(0.0, 0.0), height=0.8)
    guidance.set_pose(at(*place, 0.02))
    guidance.takeoff(0.0)
    (point,) = guidance.step(0.0).trajectory
    np.testing.assert_array_equal(point.position, (*above, 0.8))


def test_who_stands_elsewhere_and_has_references_climbs_straight_up():
    double, listed = (
        make(init_pos=(0.0, 0.0), height=0.8, takeoff_time=1.0) for make in (SimpleDIControl, TargetListGuidance)
    )
    for guidance in (double, listed):
        guidance.set_pose(at(1.5, -2.0, 0.02))
        guidance.takeoff(0.0)
    pushes = np.array([double.step(k * 0.01).reference.acceleration for k in range(50)])
    np.testing.assert_array_equal(pushes[:, :2], 0.0)
    assert pushes[-1, 2] > 0.0
    places = np.array([listed.step(k * 0.01).reference.position for k in range(50)])
    np.testing.assert_array_equal(places[:, :2], np.tile((1.5, -2.0), (50, 1)))
    assert places[-1, 2] > 0.3


def test_stop_holds_until_takeoff_or_resume():
    guidance = SimpleGuidance(init_pos=(0.0, 0.0))
    guidance.takeoff(0.0)
    guidance.stop(0.0)
    for press in (guidance.start, guidance.land):
        press(1.0)
        assert guidance.phase is Phase.STOPPED
        assert guidance.step(1.0).idle
    guidance.resume(2.0)
    assert guidance.phase is Phase.IDLE and guidance.step(2.0).idle
    guidance.stop(3.0)
    guidance.takeoff(4.0)
    assert guidance.step(4.0).trajectory is not None


def test_landing_on_the_ground_is_nothing():
    guidance = SimpleGuidance(init_pos=(0.0, 0.0))
    guidance.land(0.0)
    assert guidance.step(0.0).idle


GOALS = [(5.0, 0.5, 0.5, 1.0), (2.5, -0.5, 0.5, 1.0), (20.0, 0.0, 0.0, 0.5)]


@pytest.mark.parametrize("goals", [GOALS, [number for goal in GOALS for number in goal]], ids=["rows", "flat"])
def test_goals_come_one_after_the_other(goals):
    guidance = GoToGuidance(goals=goals, init_pos=(0.5, 0.5, 0.0))
    guidance.takeoff(0.0)
    guidance.step(0.0)
    guidance.start(6.0)
    sent = []
    for k in range(600, 4000):
        out = guidance.step(k * 0.01)
        if out.trajectory:
            sent.append((k, out.trajectory[0].time_s, *out.trajectory[0].position))
    assert sent == [(600, *GOALS[0]), (1100, *GOALS[1]), (1350, *GOALS[2])]
    assert guidance.is_done


def test_landing_ends_the_goals():
    guidance = GoToGuidance(goals=GOALS, init_pos=(0.5, 0.5, 0.0))
    guidance.start(0.0)
    guidance.step(0.0)
    guidance.land(1.0)
    assert guidance.step(1.0).trajectory[0].position[2] == 0.01
    assert all(guidance.step(1.0 + k * 0.1).trajectory is None for k in range(1, 300))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: CFGuidance(2, height=0.0), "agent 2: height is 0.0"),
        (lambda: SimpleGuidance(takeoff_time=float("nan")), "takeoff_time is nan"),
        (lambda: SimpleGuidance(init_pos=(1.0, 2.0, 3.0, 4.0)), "init_pos"),
        (lambda: GoToGuidance(goals=[(1.0, 2.0, 3.0)]), "goals have shape"),
        (lambda: GoToGuidance(goals=[(0.0, 1.0, 2.0, 3.0)]), "takes 0.0 s"),
        (lambda: SimpleGuidance().set_pose(at(0.0, np.nan, 0.0)), "pose"),
        (lambda: SimpleGuidance().set_pose(Pose(position=np.zeros(2))), "pose"),
    ],
)
def test_bad_arguments_are_named(make, words):
    with pytest.raises(RangeError, match=words):
        make()


def test_a_subclass_overrides_its_flight():
    class Circle(CFGuidance):
        def flight(self, now):
            return now

    guidance = Circle(init_pos=(0.0, 0.0))
    guidance.start(0.0)
    assert guidance.step(3.0).reference == 3.0
    guidance.land(4.0)
    assert guidance.step(4.0).reference is None
