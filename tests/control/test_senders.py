"""What senders make of thrust, attitude, rates and velocities."""

import numpy as np
import pytest

from crazychoir_fw.common.attitude import rotation
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.control import FPQRSender, FRPYSender, VelSender

RPY = np.array([0.3, -0.2, 1.1])
PQR = np.array([0.4, 0.5, 0.6])


@pytest.mark.parametrize(("sender", "rest"), [(FPQRSender(), PQR), (FRPYSender(), RPY)], ids=["fpqr", "frpy"])
@pytest.mark.parametrize("shape", [(), (4,)])
def test_thrust_comes_first(sender, rest, shape):
    thrust, attitude, pqr = np.full(shape, 0.3), np.tile(rotation(RPY), (*shape, 1, 1)), np.tile(PQR, (*shape, 1))
    u = sender.command_sender(thrust, attitude, pqr)
    assert u == pytest.approx(np.tile([0.3, *rest], (*shape, 1)))
    twist = sender.twist(u)
    assert np.array_equal(twist.linear, np.tile([0.0, 0.0, 0.3], (*shape, 1)))
    assert np.array_equal(twist.angular, u[..., 1:])


def test_hover_rates_of_one_serve_a_group():
    u = FPQRSender().command_sender(np.full(3, 0.3), np.eye(3), np.zeros(3))
    assert u == pytest.approx(np.tile([0.3, 0.0, 0.0, 0.0], (3, 1)))


def test_angles_of_an_attitude_that_points_straight_down_are_finite():
    straight_down = np.array([[0.0, 0.0, 1.0 + 1e-15], [0.0, 1.0, 0.0], [-1.0 - 1e-15, 0.0, 0.0]])
    for attitude in (straight_down, straight_down[None]):
        assert FRPYSender().command_sender(0.3, attitude, PQR).ravel()[2] == pytest.approx(np.pi / 2)


@pytest.mark.parametrize("shape", [(), (4,)])
def test_velocities_may_come_with_a_yaw_rate(shape):
    sender = VelSender()
    alone = sender.command_sender(np.tile([1.0, 2.0, 3.0], (*shape, 1)))
    assert np.array_equal(alone, np.tile([1.0, 2.0, 3.0, 0.0], (*shape, 1)))
    twist = sender.twist(sender.command_sender(np.tile([1.0, 2.0, 3.0, 0.4], (*shape, 1))))
    assert np.array_equal(twist.linear, np.tile([1.0, 2.0, 3.0], (*shape, 1)))
    assert np.array_equal(twist.angular, np.tile([0.0, 0.0, 0.4], (*shape, 1)))


def test_limits_keep_the_direction():
    sender = VelSender(max_speed=1.0, max_yaw_rate=0.5)
    assert sender.command_sender([3.0, 4.0, 0.0, -2.0]) == pytest.approx([0.6, 0.8, 0.0, -0.5])
    assert sender.command_sender([0.3, 0.4, 0.0, 0.2]) == pytest.approx([0.3, 0.4, 0.0, 0.2])
    assert sender.command_sender([0.0, 0.0, 0.0]) == pytest.approx([0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("name", ["max_speed", "max_yaw_rate"])
def test_impossible_limits_are_refused(name):
    with pytest.raises(RangeError, match=f"VelSender: {name} is 0.0, allowed: above 0"):
        VelSender(**{name: 0.0})


def test_kinds_say_what_the_numbers_are():
    assert [sender.kind for sender in (FPQRSender, FRPYSender, VelSender)] == ["fpqr", "frpy", "vel"]
