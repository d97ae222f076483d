"""Odometry of several drones as topics: one message of each is filled again and again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import odometry_bytes, read_odometry, to_stamp
from crazychoir_fw.ros.names import BODY_FRAME, ODOM, ODOM_FRAME
from crazychoir_fw.ros.node import LayerNode


class OdometryTopics:
    """Publishes poses of drones, of each to whoever listens."""

    def __init__(self, node: LayerNode, topics: Sequence[str]) -> None:
        """Make publishers of a node on topics, one for each drone."""
        self.publishers = [node.announce(ODOM, topic) for topic in topics]
        empty = Odometry(child_frame_id=BODY_FRAME)
        empty.header.frame_id = ODOM_FRAME
        self._message = read_odometry(bytes(serialize_message(empty)))

    def publish(self, time: float, poses: Pose) -> None:
        """Publish where all drones are at a time (s), arrays of shape (N, ...); what is not known is zero."""
        message, count = self._message, len(self.publishers)
        stamp = to_stamp(time)
        message.header.stamp.sec, message.header.stamp.nanosec = stamp.sec, stamp.nanosec
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        speed, rates = message.twist.twist.linear, message.twist.twist.angular
        attitudes = np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)) if poses.orientation is None else poses.orientation
        parts = [poses.position, attitudes, poses.velocity, poses.angular]
        rows = np.hstack([np.zeros((count, 3)) if part is None else part for part in parts]).tolist()
        for publisher, row in zip(self.publishers, rows, strict=True):
            if publisher.get_subscription_count():
                place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = row[:7]
                speed.x, speed.y, speed.z, rates.x, rates.y, rates.z = row[7:]
                publisher.publish(odometry_bytes(message))
