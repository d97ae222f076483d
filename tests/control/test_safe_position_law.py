"""Flatness laws behind a filter of accelerations: units, limits, integral, groups, and the controller around them."""

import numpy as np
import pytest

from crazychoir_fw import control
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import (
    FlatnessPositionCtrl,
    FPQRSender,
    GeometryAttitudeCtrl,
    SafeFlatnessAccelerationCtrl,
    SafeFlatnessPositionCtrl,
    SafeHierarchicalController,
)
from crazychoir_fw.control.safety import DoubleIntegratorCBF, SingleIntegratorCBF

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
MASS = 0.038
PAPER = 0.005 / MASS  # [m/s^2]
AHEAD = {1: Pose(position=np.array([0.25, 0.0, 1.0]), velocity=np.zeros(3))}


def pose(position=(0.0, 0.0, 1.0), velocity=(0.0, 0.0, 0.0)):
    return Pose(np.array(position), LEVEL, np.array(velocity), np.zeros(3))


def law(kind=SafeFlatnessPositionCtrl, **options):
    return kind(0, 100.0, DoubleIntegratorCBF(0.2, 5.0, 1.0, PAPER, 0.2), **options)


def acceleration(safe, now, reference, closest=None):
    """Return the horizontal acceleration that a drone of the law's mass gets (m/s^2)."""
    safe.closest = {} if closest is None else closest
    return (safe.force(now, reference) / MASS)[:2]


@pytest.mark.parametrize("gains", ["webots", "vicon", "mujoco"])
def test_without_need_it_is_the_law_that_it_makes_safe(gains):
    reference = Reference(position=np.array([0.001, -0.002, 1.1]), yaw=0.3)
    for now in (pose(), pose(velocity=(0.01, 0.0, 0.05))):
        safe = law(gains=gains).control(now, reference, {})
        plain = FlatnessPositionCtrl(100.0, gains=gains).control(now, reference)
        np.testing.assert_allclose(safe[0], plain[0])
        np.testing.assert_allclose(safe[1], plain[1], atol=2e-6)  # one period of the integral


def test_the_filter_speaks_of_accelerations():
    """The paper's 0.005 N are 0.13 m/s^2 of a drone of 38 g."""
    far = Reference(position=np.array([5.0, 0.0, 1.0]), acceleration=np.array([3.0, 0.0, 0.0]))
    np.testing.assert_allclose(acceleration(law(), pose(), far), [PAPER, 0.0], atol=1e-9)
    filter_ = DoubleIntegratorCBF(0.2, 5.0, 1.0, PAPER, 0.2)
    now = pose(velocity=(0.05, 0.0, 0.0))
    wanted = filter_.filter([PAPER, 0.0], now, AHEAD)
    assert wanted[0] < 0.0
    np.testing.assert_allclose(acceleration(law(), now, far, AHEAD), wanted, atol=1e-12)
    follows = Reference(acceleration=np.array([PAPER, 0.0, 0.0]))
    np.testing.assert_allclose(acceleration(law(SafeFlatnessAccelerationCtrl), now, follows, AHEAD), wanted, atol=1e-12)


def test_too_much_is_cut_along_its_direction():
    wish = Reference(acceleration=np.array([3.0, 1.0, 0.0]))
    np.testing.assert_allclose(
        acceleration(law(SafeFlatnessAccelerationCtrl), pose(), wish), PAPER * np.array([3.0, 1.0]) / np.sqrt(10.0)
    )


@pytest.mark.parametrize("gains", ["mujoco"])
def test_a_drone_that_was_held_up_arrives_without_overshoot(gains):
    safe, reference = law(gains=gains, mass=MASS), Reference(position=np.array([1.0, 0.5, 1.0]))
    position, velocity, farthest = np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0
    for _ in range(4000):
        u = np.append(acceleration(safe, pose(position, velocity), reference), 0.0)
        position, velocity = position + 0.01 * velocity + 5e-5 * u, velocity + 0.01 * u
        farthest = max(farthest, position[0])
    np.testing.assert_allclose(position, [1.0, 0.5, 1.0], atol=0.005)
    assert farthest < 1.03


def test_disturbances_are_no_business_of_the_filter():
    """A wind of 0.3 m/s^2 on a drone that wants to stay: more than the filter allows, and yet held."""
    safe, reference = law(gains="mujoco", mass=MASS), Reference(position=np.array([0.0, 0.0, 1.0]))
    position, velocity = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    for _ in range(2000):
        wind = np.array([0.3, 0.0, 0.0])
        u = np.append(acceleration(safe, pose(position, velocity), reference), 0.0) + wind
        position, velocity = position + 0.01 * velocity + 5e-5 * u, velocity + 0.01 * u
    np.testing.assert_allclose(position, [0.0, 0.0, 1.0], atol=0.02)
    np.testing.assert_allclose(safe.disturbance, [0.3, 0.0], atol=0.01)
    safe.reset()
    np.testing.assert_allclose(acceleration(safe, pose(), reference), [0.0, 0.0], atol=1e-9)


def test_who_is_kept_waiting_learns_nothing_from_it():
    safe, reference = law(gains="mujoco"), Reference(position=np.array([0.02, 0.0, 1.0]))
    near = {1: Pose(position=np.array([0.2, 0.0, 1.0]), velocity=np.zeros(3))}
    for _ in range(50):
        safe.control(pose(), reference, near)
    assert safe.altered
    np.testing.assert_allclose(safe.disturbance, 0.0, atol=1e-12)


def test_a_group_is_each_as_if_alone():
    dice = np.random.default_rng(1)
    positions, velocities = dice.uniform(-1, 1, (6, 3)), dice.uniform(-0.05, 0.05, (6, 3))
    goals = positions + dice.uniform(-0.1, 0.1, (6, 3))
    others = Pose(position=positions[:, None] + dice.uniform(-1, 1, (6, 3, 3)), velocity=np.zeros((6, 3, 3)))
    masses = np.linspace(0.03, 0.04, 6)
    many = law(gains="mujoco", mass=masses)
    group = Pose(positions, np.tile(LEVEL, (6, 1)), velocities, np.zeros((6, 3)))
    jerk = dice.uniform(-1, 1, (6, 3))
    thrust, attitude = many.control(group, Reference(position=goals, jerk=jerk), others)
    for i in range(6):
        one = law(gains="mujoco", mass=masses[i])
        near = {k: Pose(position=others.position[i, k], velocity=np.zeros(3)) for k in range(3)}
        alone = one.control(pose(positions[i], velocities[i]), Reference(position=goals[i], jerk=jerk[i]), near)
        np.testing.assert_allclose(alone[0], thrust[i])
        np.testing.assert_allclose(alone[1], attitude[i], atol=1e-12)
        np.testing.assert_allclose(one.desired_rates, many.desired_rates[i], atol=1e-12)
        if one.altered:
            assert not one.desired_rates[:2].any()


def test_the_controller_hands_over_who_is_near():
    heard = []

    class Curious(control.PositionCtrlStrategy):
        def control(self, current_pose, desired_reference, closest):
            heard.append(closest)
            return np.array(0.3), np.eye(3)

    controller = SafeHierarchicalController(Curious(), GeometryAttitudeCtrl(), FPQRSender())
    controller.set_pose(pose())
    controller.step(0.0)
    controller.set_closest(AHEAD)
    assert controller.step(0.01) is not None
    assert heard == [None, AHEAD]


@pytest.mark.parametrize("filter_", [None, SingleIntegratorCBF()])
def test_a_filter_of_accelerations_is_needed(filter_):
    with pytest.raises(RangeError, match=r"allowed: a filter of accelerations \(DoubleIntegratorCBF\)"):
        SafeFlatnessPositionCtrl(0, 100.0, filter_)


def test_max_acceleration_is_checked():
    with pytest.raises(RangeError, match="max_acceleration is 0.0, allowed: above 0"):
        SafeFlatnessPositionCtrl(0, 100.0, DoubleIntegratorCBF(), 0.0)
