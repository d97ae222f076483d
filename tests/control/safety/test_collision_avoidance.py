"""Filters between controllers and drones, as plain classes."""

import numpy as np
import pytest

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Twist
from crazychoir_fw.control.safety import (
    DoubleIntegratorCBF,
    DoubleIntegratorCollisionAvoidance,
    SingleIntegratorCBF,
    SingleIntegratorCollisionAvoidance,
    UnicycleCollisionAvoidance,
)

AHEAD = {1: Pose(position=np.array([0.6, 0.0, 1.0]), velocity=np.zeros(3))}


def test_velocities_are_those_of_the_filter_and_turning_passes():
    avoidance = SingleIntegratorCollisionAvoidance(SingleIntegratorCBF())
    assert avoidance.step() is None
    avoidance.set_desired(Twist(np.array([0.1, 0.05, 0.3]), np.array([0.0, 0.0, 0.7])))
    assert avoidance.step() is None
    avoidance.set_pose(Pose(position=np.array([0.0, 0.0, 1.0])))
    np.testing.assert_allclose(avoidance.step().linear, [0.1, 0.05, 0.3])
    avoidance.set_closest(AHEAD)
    safe = avoidance.step()
    np.testing.assert_allclose(safe.linear, [5.0 * 0.2**3 / 1.2, 0.05, 0.3])
    np.testing.assert_array_equal(safe.angular, [0.0, 0.0, 0.7])
    np.testing.assert_array_equal(avoidance.standstill().linear, np.zeros(3))


def test_accelerations_wait_for_a_velocity():
    avoidance = DoubleIntegratorCollisionAvoidance(DoubleIntegratorCBF())
    avoidance.set_desired([0.05, 0.0, 1.0])
    avoidance.set_pose(Pose(position=np.zeros(3)))
    assert avoidance.step() is None
    avoidance.set_pose(Pose(position=np.zeros(3), velocity=np.array([0.3, 0.4, 0.0])))
    np.testing.assert_allclose(avoidance.step(), [0.05, 0.0, 1.0])
    np.testing.assert_allclose(avoidance.standstill(), [-0.12, -0.16, 0.0])


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_a_unicycle_keeps_the_point_in_front_of_it_apart(yaw):
    filter_ = SingleIntegratorCBF(distance=0.3, gamma=5.0, max_velocity=1.0)
    avoidance = UnicycleCollisionAvoidance(filter_)
    heading = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    pose = Pose(position=np.zeros(3), orientation=quaternion_xyzw(np.array([0.0, 0.0, yaw])))
    avoidance.set_pose(pose)
    avoidance.set_desired(Twist(np.array([0.2, 0.0, 0.0]), np.array([0.0, 0.0, 0.5])))
    same = avoidance.step()
    np.testing.assert_allclose([same.linear[0], same.angular[2]], [0.2, 0.5])
    avoidance.set_closest({1: Pose(position=0.6 * heading)})
    safe = avoidance.step()
    assert safe.linear[0] == pytest.approx(5.0 * (0.5**2 - 0.3**2) ** 3 / (2 * 0.5))
    assert safe.angular[2] == pytest.approx(0.5)


def test_many_at_once_are_each_as_if_alone():
    dice = np.random.default_rng(3)
    positions, wishes = dice.uniform(-1, 1, (5, 3)), dice.uniform(-0.2, 0.2, (5, 3))
    others = positions[:, None] + dice.uniform(-1, 1, (5, 2, 3))
    many = SingleIntegratorCollisionAvoidance(SingleIntegratorCBF(keep_right=1.0))
    many.set_pose(Pose(position=positions))
    many.set_closest(Pose(position=others))
    many.set_desired(Twist(wishes, np.zeros((5, 3))))
    together = many.step().linear
    for i in range(5):
        alone = SingleIntegratorCollisionAvoidance(SingleIntegratorCBF(keep_right=1.0))
        alone.set_pose(Pose(position=positions[i]))
        alone.set_closest({k: Pose(position=others[i, k]) for k in range(2)})
        alone.set_desired(Twist(wishes[i], np.zeros(3)))
        np.testing.assert_allclose(alone.step().linear, together[i], atol=1e-12)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: SingleIntegratorCollisionAvoidance(), "safety_filter is NoneType, allowed: SingleIntegratorCBF"),
        (lambda: DoubleIntegratorCollisionAvoidance(SingleIntegratorCBF()), "allowed: DoubleIntegratorCBF"),
        (lambda: UnicycleCollisionAvoidance(SingleIntegratorCBF(), 0.0), "look_ahead is 0.0, allowed: above 0 m"),
    ],
)
def test_bad_arguments_are_named(call, says):
    with pytest.raises(RangeError, match=says):
        call()
