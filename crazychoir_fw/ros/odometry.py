"""Odometry as bytes: numbers are written straight into messages, and read straight out of them."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np
from nav_msgs.msg import Odometry

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import from_bytes, odometry_to_pose, to_stamp
from crazychoir_fw.ros.names import BODY_FRAME, ODOM, ODOM_FRAME
from crazychoir_fw.ros.node import LayerNode

_FRAMES = tuple(part for frame in (ODOM_FRAME, BODY_FRAME) for part in (len(frame) + 1, frame.encode()))
# CDR: stamp, frames, pose, twist, and covariances of zeros; packed in 0.4 us; rosbags takes 7 us
_ODOMETRY = struct.Struct("<2s2x iI I5s3x I10s6x 7d288x 6d288x")
_ROUNDING = 1e-3  # of the length of a quaternion


class OdometryTopics:
    """Publishes poses of drones, each on its own topic, if that has a subscriber."""

    def __init__(self, node: LayerNode, topics: Sequence[str]) -> None:
        """Make publishers of a node on topics, one for each drone."""
        self.publishers = [node.announce(ODOM, topic) for topic in topics]

    def publish(self, time: float, poses: Pose) -> None:
        """Publish where all drones are at a time (s), arrays of shape (N, ...); unknown values are zero."""
        stamp, count = to_stamp(time), len(self.publishers)
        head = (b"\x00\x01", stamp.sec, stamp.nanosec, *_FRAMES)
        attitudes = np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)) if poses.orientation is None else poses.orientation
        parts = [poses.position, attitudes, poses.velocity, poses.angular]
        rows = np.hstack([np.zeros((count, 3)) if part is None else part for part in parts]).tolist()
        for publisher, row in zip(self.publishers, rows, strict=True):
            if publisher.get_subscription_count():
                publisher.publish(_ODOMETRY.pack(*head, *row))


def bytes_to_pose(data: bytes) -> Pose:
    """Return odometry as a pose; a stamp of zero is no stamp.

    Messages of `OdometryTopics` take a sixth of the time of any other odometry.

    Raises:
        RangeError: If a number is not finite, or the quaternion is none.
    """
    if len(data) == _ODOMETRY.size:
        head, numbers = (fields := _ODOMETRY.unpack(data))[:7], np.array(fields[7:])
        if head[0] == b"\x00\x01" and head[3:] == _FRAMES and math.isfinite(numbers.sum()):
            attitude = numbers[3:7]
            norm = math.sqrt(float(attitude @ attitude))
            if abs(norm - 1.0) < _ROUNDING:
                time = (head[1] * 1_000_000_000 + head[2]) / 1e9
                return Pose(numbers[:3], attitude / norm, numbers[7:10], numbers[10:], time or None)
    return odometry_to_pose(from_bytes(data, Odometry))
