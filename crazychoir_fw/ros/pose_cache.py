"""Latest positions of drones from odometry, for communication graphs that depend on distance."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.names import ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe


class PoseCache:
    """Latest positions of drones, as received by one node; each node derives its own neighbors from them."""

    def __init__(self, count: int) -> None:
        """Begin with `count` unknown positions."""
        self._positions = np.full((count, 3), np.nan)

    def positions(self) -> NDArray[np.float64]:
        """Return them (m, world), shape (N, 3); NaN before the first odometry, so the drone is in no range."""
        return self._positions

    def watch(self, node: LayerNode, numbers: Iterable[int]) -> None:
        """Subscribe to the odometry of drones at a node."""
        for number in numbers:
            pose_subscribe("pubsub", node.topic_of(number, ODOM.name), node, self._taker(number))

    def _taker(self, number: int) -> Callable[[Pose], None]:
        def take(pose: Pose) -> None:
            self._positions[number] = pose.position

        return take
