"""Body rates of the geometric attitude law: numbers of the original and of what it meant, feed-forward, batches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crazychoir_fw.common.attitude import angle_rates, legacy_rates, quaternion_xyzw, rotation
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import AttitudeGains, FlatnessPositionCtrl, GeometryAttitudeCtrl

RPY = np.array([0.1, -0.2, 0.3])
POSE = Pose(np.array([0.1, -0.2, 0.9]), quaternion_xyzw(RPY), np.array([0.05, 0.1, -0.02]), np.array([0.3, -0.4, 0.2]))
REFERENCE = Reference(np.array([0.0, 0.0, 1.0]), np.array([0.1, 0.0, 0.0]), np.array([0.2, -0.1, 0.3]), yaw=0.25)

NUMBERS = {  # true body rates, and the same through the matrix of the original
    False: ((-3.639119018, 3.155181141, -0.023211827), (-3.698289398, 3.134806899, 0.297833489), 3.141735693),
    True: ((-4.178564492, 1.914735236, -0.226220958), (-4.171685276, 1.860226369, -0.034626459), 1.927753946),
}


@pytest.mark.parametrize("vicon", NUMBERS, ids=["webots", "vicon"])
def test_numbers_of_the_original(vicon):
    body_rates, published, corrected = NUMBERS[vicon]
    _, attitude = FlatnessPositionCtrl(vicon=vicon).control(POSE, REFERENCE)
    found = GeometryAttitudeCtrl(vicon=vicon).control(POSE, attitude, REFERENCE)
    assert found == pytest.approx(body_rates, abs=1e-8)
    legacy = GeometryAttitudeCtrl(vicon=vicon, legacy=True).control(POSE, attitude, REFERENCE)
    assert legacy == pytest.approx(published, abs=1e-8)
    # with the right matrix these are rates of roll, pitch and yaw
    assert angle_rates(RPY, found) == pytest.approx([published[0], corrected, published[2]], abs=1e-8)


def test_legacy_undoes_what_the_legacy_integrator_does():
    law, attitude = GeometryAttitudeCtrl(), rotation(np.array([0.3, 0.2, -0.1]))
    rates = law.control(POSE, attitude, REFERENCE)
    legacy = GeometryAttitudeCtrl(legacy=True).control(POSE, attitude, REFERENCE)
    assert legacy_rates(RPY, legacy) == pytest.approx(rates)


def test_straight_up_the_legacy_rates_are_finite():
    straight_up = Pose(orientation=quaternion_xyzw(np.array([0.0, np.pi / 2, 0.0])))
    assert np.all(np.isfinite(GeometryAttitudeCtrl(legacy=True).control(straight_up, np.eye(3), REFERENCE)))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rates_turn_towards_the_desired_attitude(axis):
    angles = np.zeros(3)
    angles[axis] = 0.2
    level = Pose(orientation=np.array([0.0, 0.0, 0.0, 1.0]), angular=np.zeros(3))
    rates = GeometryAttitudeCtrl(gains=AttitudeGains(5.0, 0.0)).control(level, rotation(angles), REFERENCE)
    assert rates[axis] == pytest.approx(5.0 * np.sin(0.2))
    assert np.delete(rates, axis) == pytest.approx([0.0, 0.0])


def test_on_its_way_a_drone_turns_as_the_desired_attitude_does():
    law = GeometryAttitudeCtrl()
    law.desired_rates = np.array([1.0, -2.0, 0.5])
    on_its_way = Pose(orientation=quaternion_xyzw(RPY), angular=law.desired_rates)
    assert law.control(on_its_way, rotation(RPY), REFERENCE) == pytest.approx(law.desired_rates)


def test_desired_rates_are_seen_from_the_body():
    """A drone that lies a quarter turn about z away sees x as its y."""
    law = GeometryAttitudeCtrl(gains=AttitudeGains(0.0, 0.0))
    law.desired_rates = np.array([1.0, 0.0, 0.0])
    turned = Pose(orientation=quaternion_xyzw(np.array([0.0, 0.0, -np.pi / 2])), angular=np.zeros(3))
    assert law.control(turned, np.eye(3), REFERENCE) == pytest.approx([0.0, 1.0, 0.0])


def test_without_a_gyro_nothing_damps():
    law, attitude = GeometryAttitudeCtrl(), rotation(np.array([0.2, 0.0, 0.0]))
    known = Pose(orientation=POSE.orientation, angular=np.zeros(3))
    unknown = Pose(orientation=POSE.orientation)
    assert np.array_equal(law.control(known, attitude, REFERENCE), law.control(unknown, attitude, REFERENCE))


angles = arrays(float, (5, 3), elements=st.floats(-3.0, 3.0))


@pytest.mark.parametrize("legacy", [False, True])
@given(rpy=angles, wanted=angles, rates=angles, ahead=angles)
def test_a_batch_is_as_one_by_one(legacy, rpy, wanted, rates, ahead):
    law = GeometryAttitudeCtrl(legacy=legacy)
    law.desired_rates = ahead
    q, R = quaternion_xyzw(rpy), rotation(wanted)
    together = law.control(Pose(orientation=q, angular=rates), R, REFERENCE)
    for i in range(5):
        law.desired_rates = ahead[i]
        alone = law.control(Pose(orientation=q[i], angular=rates[i]), R[i], REFERENCE)
        # Euler angles magnify rounding where the nose points up
        scale = 1.0 / max(np.abs(np.cos(rpy[i, 1])), 1e-6) ** 2 if legacy else 1.0
        assert together[i] == pytest.approx(alone, abs=1e-12 * scale, rel=1e-12 * scale)


@given(wanted=angles, rpy=angles)
def test_the_error_shrinks(wanted, rpy):
    """Turning at these rates brings the attitude nearer, wherever it is."""
    R, R_d = rotation(rpy[0]), rotation(wanted[0])
    law = GeometryAttitudeCtrl(gains=AttitudeGains(1.0, 0.0))
    w = law.control(Pose(orientation=quaternion_xyzw(rpy[0])), R_d, REFERENCE)
    hat = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    assert np.trace(R_d.T @ R @ hat) >= -1e-12  # the rate of change of the trace, 3 when they agree


def test_one_attitude_for_many_poses():
    quats = np.random.default_rng(2).normal(size=(5, 4))
    law, attitude = GeometryAttitudeCtrl(gains="mujoco"), rotation(np.array([0.1, -0.2, 0.3]))
    found = law.control(Pose(orientation=quats), attitude, REFERENCE)
    one_by_one = [law.control(Pose(orientation=quat), attitude, REFERENCE) for quat in quats]
    np.testing.assert_array_equal(found, one_by_one)
