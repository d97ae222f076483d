"""Rotations between roll, pitch, yaw, quaternions and matrices agree, for one drone and for many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crazychoir_fw.common.attitude import quaternion_xyzw, rotation, rotation_of_quaternion, rpy_of_rotation
from crazychoir_fw.common.messages import Pose

angle = st.floats(-3.1, 3.1)
pitch = st.floats(-1.5, 1.5)


@given(st.lists(st.tuples(angle, pitch, angle), min_size=1, max_size=5))
def test_all_ways_agree_with_scipy(angles):
    rpy = np.array(angles)
    expected = Rotation.from_euler("xyz", rpy)
    assert rotation(rpy) == pytest.approx(expected.as_matrix(), abs=1e-12)
    quat = quaternion_xyzw(rpy)
    assert rotation_of_quaternion(3.0 * quat) == pytest.approx(expected.as_matrix(), abs=1e-12)
    assert rpy_of_rotation(rotation(rpy)) == pytest.approx(rpy, abs=1e-9)


def test_one_drone_has_no_leading_dimension():
    rpy = np.array([0.1, -0.2, 0.3])
    R = rotation_of_quaternion(quaternion_xyzw(rpy))
    assert R.shape == (3, 3)
    assert rpy_of_rotation(R) == pytest.approx(rpy)
    assert pytest.approx(rotation(rpy)) == R


@pytest.mark.parametrize("shape", [(4,), (3, 4)])
def test_rotation_of_a_pose_follows_what_is_written_into_it(shape):
    quat = np.random.default_rng(1).normal(size=shape)
    pose = Pose(orientation=quat)
    assert pose.rotation is pose.rotation
    assert pose.rotation == pytest.approx(rotation_of_quaternion(quat))
    quat[...] = np.random.default_rng(2).normal(size=shape)
    assert pose.rotation == pytest.approx(rotation_of_quaternion(quat))
    pose.orientation = np.array([0.0, 0.0, 0.0, 1.0])
    assert pose.rotation == pytest.approx(np.eye(3))
