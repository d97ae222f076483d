"""Messages of pose sources as plain poses, without ROS: fields are all that is read."""

from types import SimpleNamespace as Fields

import numpy as np

from crazychoir_fw.mocap import decode_odometry, decode_pose_stamped, decode_vicon_position

HEADER = Fields(stamp=Fields(sec=3, nanosec=250_000_000))
POSE = Fields(position=Fields(x=1.0, y=-2.0, z=0.5), orientation=Fields(x=0.1, y=0.2, z=0.3, w=0.9))


def test_pose_stamped_is_in_meters():
    pose = decode_pose_stamped(Fields(header=HEADER, pose=POSE))
    assert pose.time == 3.25
    np.testing.assert_array_equal(pose.position, [1.0, -2.0, 0.5])
    np.testing.assert_array_equal(pose.orientation, [0.1, 0.2, 0.3, 0.9])
    assert pose.velocity is None and pose.angular is None


def test_the_legacy_message_is_in_millimeters_and_has_no_stamp():
    message = Fields(x_trans=1000.0, y_trans=-250.0, z_trans=1.5, x_rot=0.0, y_rot=0.0, z_rot=0.0, w=1.0)
    pose = decode_vicon_position(message, now=7.0)
    np.testing.assert_allclose(pose.position, [1.0, -0.25, 0.0015])
    assert pose.time == 7.0
    assert decode_vicon_position(message).time is None


def test_odometry_brings_velocities():
    twist = Fields(linear=Fields(x=0.1, y=0.2, z=0.3), angular=Fields(x=4.0, y=5.0, z=6.0))
    pose = decode_odometry(Fields(header=HEADER, pose=Fields(pose=POSE), twist=Fields(twist=twist)))
    np.testing.assert_array_equal(pose.velocity, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(pose.angular, [4.0, 5.0, 6.0])


def test_a_stamp_of_zero_is_none_and_occluded_zeros_stay_zeros():
    nothing = Fields(position=Fields(x=0.0, y=0.0, z=0.0), orientation=Fields(x=0.0, y=0.0, z=0.0, w=0.0))
    pose = decode_pose_stamped(Fields(header=Fields(stamp=Fields(sec=0, nanosec=0)), pose=nothing))
    assert pose.time is None
    np.testing.assert_array_equal(pose.orientation, 0.0)
