"""Rotations between roll, pitch, yaw, quaternions and matrices agree, for one drone and for many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crazychoir_fw.attitude import quaternion_xyzw, rotation, rotation_of_quaternion, rpy_of_rotation

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
