"""Messages of pose sources as plain poses (docs/reference/crazychoir.md#2.2, #14).

Only fields are read, so that nothing of ROS is needed. What the message says is passed on as it is, also zeros and
NaN: the filter of poses decides what a lost sample is.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crazychoir_fw.common.messages import Pose

_MILLIMETER = 1e-3


def decode_pose_stamped(message: Any) -> Pose:
    """Return a ``geometry_msgs/PoseStamped``: meters, world frame, as Vicon, OptiTrack and others publish it now."""
    pose = message.pose
    return Pose(
        position=np.array(_xyz(pose.position)),
        orientation=np.array(_xyzw(pose.orientation)),
        time=_stamp(message),
    )


def decode_vicon_position(message: Any, now: float | None = None) -> Pose:
    """Return a legacy ``vicon_receiver/Position``: millimeters and no stamp.

    Args:
        message: Fields ``x_trans``, ``y_trans``, ``z_trans`` (mm), ``x_rot``, ``y_rot``, ``z_rot``, ``w``.
        now: When it came (s), since it does not say itself.
    """
    return Pose(
        position=_MILLIMETER * np.array((message.x_trans, message.y_trans, message.z_trans), float),
        orientation=np.array((message.x_rot, message.y_rot, message.z_rot, message.w), float),
        time=now,
    )


def decode_odometry(message: Any) -> Pose:
    """Return a ``nav_msgs/Odometry``: linear velocity in the world, angular velocity in the body."""
    pose, twist = message.pose.pose, message.twist.twist
    return Pose(
        position=np.array(_xyz(pose.position)),
        orientation=np.array(_xyzw(pose.orientation)),
        velocity=np.array(_xyz(twist.linear)),
        angular=np.array(_xyz(twist.angular)),
        time=_stamp(message),
    )


def _xyz(vector: Any) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z


def _xyzw(quaternion: Any) -> tuple[float, float, float, float]:
    return quaternion.x, quaternion.y, quaternion.z, quaternion.w


def _stamp(message: Any) -> float | None:
    """Return the stamp (s); one of zero is none."""
    stamp = message.header.stamp
    nanoseconds = stamp.sec * 1_000_000_000 + stamp.nanosec
    return nanoseconds / 1e9 if nanoseconds else None
