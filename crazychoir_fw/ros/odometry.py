"""Odometry of several drones as topics; filling one message again and again takes a third of making a new one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from nav_msgs.msg import Odometry

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import to_stamp
from crazychoir_fw.ros.names import BODY_FRAME, ODOM, ODOM_FRAME
from crazychoir_fw.ros.node import LayerNode


class OdometryTopics:
    """Publishes poses of drones, of each to whoever listens."""

    def __init__(self, node: LayerNode, topics: Sequence[str]) -> None:
        """Make publishers of a node on topics, one for each drone."""
        self.publishers = [node.announce(ODOM, topic) for topic in topics]
        self._messages = [Odometry(child_frame_id=BODY_FRAME) for _ in topics]
        for message in self._messages:
            message.header.frame_id = ODOM_FRAME

    def publish(self, time: float, poses: Pose) -> None:
        """Publish where all drones are at a time (s), arrays of shape (N, ...); what is not known is zero."""
        stamp, count = to_stamp(time), len(self.publishers)
        attitudes = np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)) if poses.orientation is None else poses.orientation
        parts = [poses.position, attitudes, poses.velocity, poses.angular]
        rows = np.hstack([np.zeros((count, 3)) if part is None else part for part in parts]).tolist()
        for publisher, message, row in zip(self.publishers, self._messages, rows, strict=True):
            if not publisher.get_subscription_count():
                continue
            message.header.stamp = stamp
            place, turn = message.pose.pose.position, message.pose.pose.orientation
            speed, rates = message.twist.twist.linear, message.twist.twist.angular
            place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = row[:7]
            speed.x, speed.y, speed.z, rates.x, rates.y, rates.z = row[7:]
            publisher.publish(message)
