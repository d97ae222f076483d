"""Velocity law and controller."""

import numpy as np
import pytest

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import FPQRSender, VelocityController, VelocityCtrlStrategy, VelocityGains, VelSender

POSE = Pose(np.array([0.1, -0.2, 0.9]), quaternion_xyzw(np.array([0.1, -0.2, 0.3])), np.array([0.05, 0.1, -0.02]))


def test_numbers_of_the_original():
    reference = Reference(np.array([0.0, 0.0, 1.0]), np.array([0.1, 0.0, 0.0]))
    assert VelocityCtrlStrategy().control(POSE, reference) == pytest.approx([-0.0395, 0.079, 0.0402, 0.0])


def test_without_a_velocity_the_drone_is_to_stand_still():
    command = VelocityCtrlStrategy().control(POSE, Reference(POSE.position))
    assert command[:3] == pytest.approx(-0.01 * POSE.velocity)


def test_velocity_of_the_reference_is_fed_forward():
    law = VelocityCtrlStrategy(gains=VelocityGains(0.4, 0.0, feed_forward=0.5))
    command = law.control(POSE, Reference(POSE.position, np.array([1.0, 0.0, -0.4])))
    assert command[:3] == pytest.approx([0.5, 0.0, -0.2])


@pytest.mark.parametrize(
    ("yaw", "yaw_rate", "turn"),
    [(0.5, None, 0.2), (0.5, 0.1, 0.3), (None, 0.1, 0.1), (0.3 + np.pi + 0.5, None, 0.5 - np.pi)],
)
def test_it_turns_the_short_way_to_the_heading(yaw, yaw_rate, turn):
    command = VelocityCtrlStrategy().control(POSE, Reference(POSE.position, yaw=yaw, yaw_rate=yaw_rate))
    assert command[3] == pytest.approx(turn)


def test_a_batch_is_as_one_by_one():
    rng = np.random.default_rng(2)
    p, q, v, goal, yaw = (rng.normal(size=size) for size in ((5, 3), (5, 4), (5, 3), (5, 3), 5))
    law = VelocityCtrlStrategy(gains="mujoco")
    together = law.control(Pose(p, q, v), Reference(goal, yaw=yaw))
    for i in range(5):
        alone = law.control(Pose(p[i], q[i], v[i]), Reference(goal[i], yaw=yaw[i]))
        assert together[i] == pytest.approx(alone, abs=1e-12)


def test_zero_is_sent_without_pose_or_reference():
    controller = VelocityController(VelocityCtrlStrategy(), VelSender())
    assert controller.step(0.0).linear.tolist() == [0.0, 0.0, 0.0]
    controller.set_pose(POSE)
    assert controller.step(0.01).linear.tolist() == [0.0, 0.0, 0.0]
    controller.set_reference(Reference(np.zeros(3)))
    assert controller.step(0.02).linear[0] < 0.0
    controller.clear_reference()
    assert controller.step(0.03).linear.tolist() == [0.0, 0.0, 0.0]


def test_it_runs_at_the_frequency_of_the_law():
    controller = VelocityController(VelocityCtrlStrategy(10.0), VelSender())
    assert controller.periods == (0.1,)
    sent = [controller.step(0.01 * i) is not None for i in range(21)]
    assert np.flatnonzero(sent).tolist() == [0, 10, 20]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((None, VelSender()), "velocity_strategy is None"),
        ((VelocityCtrlStrategy(), None), "command_sender is None"),
        ((VelocityCtrlStrategy(), FPQRSender()), "command_sender sends fpqr, allowed: vel"),
    ],
)
def test_parts_that_do_not_fit_are_refused(arguments, message):
    with pytest.raises(RangeError, match=f"VelocityController: {message}"):
        VelocityController(*arguments)
