"""Poles of the closed loop in hover, with ideal body rates (docs/reference/crazychoir.md#4.4)."""

import numpy as np
import pytest

from crazychoir_fw.common.attitude import angle_rates, quaternion_xyzw, rotation
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import FlatnessPositionCtrl, GeometryAttitudeCtrl

MASS, GRAVITY = 0.038, 9.80665
HOVER = Reference(np.zeros(3), np.zeros(3), np.zeros(3), yaw=0.0)


def derivative(state, gains):
    """Position, velocity and angles of a drone that reaches the commanded body rates at once."""
    position, velocity, rpy = state.reshape(3, 3)
    pose = Pose(position, quaternion_xyzw(rpy), velocity, np.zeros(3))
    thrust, attitude = FlatnessPositionCtrl(gains=gains, mass=MASS).control(pose, HOVER)
    law = GeometryAttitudeCtrl(gains=gains)
    # the rates that are commanded are those that are measured: w = command(0) - k_w w
    rates = law.control(pose, attitude, HOVER) / (1.0 + np.array(law.gains.k_w))
    force = thrust * rotation(rpy)[:, 2] - [0.0, 0.0, MASS * GRAVITY]
    return np.concatenate([velocity, force / MASS, angle_rates(rpy, rates)])


def poles(gains, states):
    h = 1e-6
    jacobian = np.array([(derivative(e, gains) - derivative(-e, gains)) / (2 * h) for e in h * np.eye(9)]).T
    assert np.abs(np.delete(jacobian[:, states], states, axis=0)).max() < 1e-6  # these states go by themselves
    found = np.linalg.eigvals(jacobian[np.ix_(states, states)])
    return found[np.lexsort((found.real, found.imag))]


LATERAL_X, LATERAL_Y, VERTICAL, YAW = [0, 3, 7], [1, 4, 6], [2, 5], [8]


@pytest.mark.parametrize(
    ("gains", "lateral", "vertical"),
    [
        ("webots", (-3.33 - 4.35j, -3.59, -3.33 + 4.35j), (-5.26 - 2.28j, -5.26 + 2.28j)),
        ("vicon", (-0.67 - 4.60j, -9.57, -0.67 + 4.60j), (-5.26 - 3.43j, -5.26 + 3.43j)),
    ],
)
def test_poles_of_the_original_sets(gains, lateral, vertical):
    assert poles(gains, LATERAL_X) == pytest.approx(lateral, abs=0.006)
    assert poles(gains, LATERAL_Y) == pytest.approx(lateral, abs=0.006)
    assert poles(gains, VERTICAL) == pytest.approx(vertical, abs=0.006)


def test_our_set_is_well_damped():
    for states in (LATERAL_X, LATERAL_Y, VERTICAL, YAW):
        found = poles("mujoco", states)
        assert np.all(found.real < -1.0)
        assert np.all(-found.real / np.abs(found) > 0.5)
