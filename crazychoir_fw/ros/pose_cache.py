"""Where others are, for graphs of communication that go by distance: as odometry tells."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.names import ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe


class PoseCache:
    """Positions of drones as one node hears them; each node decides by itself whom it hears."""

    def __init__(self, count: int) -> None:
        """Know nothing of so many drones."""
        self._positions = np.full((count, 3), np.nan)

    def positions(self) -> NDArray[np.float64]:
        """Return them (m, world), shape (N, 3); NaN for whoever was not heard of, who is near nobody."""
        return self._positions

    def watch(self, node: LayerNode, numbers: Iterable[int]) -> None:
        """Hear the odometry of drones at a node."""
        for number in numbers:
            pose_subscribe("pubsub", node.topic_of(number, ODOM.name), node, self._taker(number))

    def _taker(self, number: int) -> Callable[[Pose], None]:
        def take(pose: Pose) -> None:
            self._positions[number] = pose.position

        return take
