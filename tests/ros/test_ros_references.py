"""References as bytes: the same as rclpy writes and reads."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference
from crazychoir_fw.ros.conversions import message_to_reference, reference_to_message
from crazychoir_fw.ros.wire import bytes_to_reference, reference_bytes, vector3_bytes

NUMBER = st.floats(-1e6, 1e6)
VECTOR = st.lists(NUMBER, min_size=3, max_size=3).map(np.array)


# ---------------------------------------------------------------- bytes


@given(VECTOR, VECTOR, VECTOR, st.floats(-math.pi, math.pi), NUMBER)
def test_full_states_are_what_rclpy_encodes(position, velocity, acceleration, yaw, turn):
    reference = Reference(position, velocity, acceleration, yaw=yaw, yaw_rate=turn)
    ours = deserialize_message(reference_bytes(reference, "fullstate"), MultiDOFJointTrajectoryPoint)
    assert ours == reference_to_message(reference, "fullstate")
    read = bytes_to_reference(bytes(serialize_message(ours)), "fullstate")
    decoded = message_to_reference(ours, "fullstate")
    for name in ("position", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(read, name), getattr(decoded, name))
    assert read.yaw == pytest.approx(decoded.yaw, abs=1e-9)
    assert read.yaw_rate == decoded.yaw_rate


def test_full_states_of_another_form_are_decoded_too():
    reference = Reference(np.array([1.0, 2.0, 3.0]))
    read = bytes_to_reference(reference_bytes(reference, "fullstate"), "fullstate")
    np.testing.assert_array_equal(read.position, reference.position)
    assert read.velocity is None and read.acceleration is None


@pytest.mark.parametrize("kind", ["acceleration", "position", "fullstate"])
def test_references_that_are_not_finite_are_refused_both_ways(kind):
    bad = np.array([0.0, math.nan, 0.0])
    with pytest.raises(RangeError, match="finite"):
        reference_bytes(Reference(bad, bad, bad), kind)
    if kind != "fullstate":
        with pytest.raises(RangeError, match=f"{kind}.*finite"):
            bytes_to_reference(vector3_bytes(*bad), kind)
