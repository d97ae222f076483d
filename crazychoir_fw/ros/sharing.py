"""Topics that the layers of one drone share in one process, so that the middleware carries them once or not at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.controller import CrazyflieController
from crazychoir_fw.ros.guidance_node import GuidanceNode
from crazychoir_fw.ros.names import ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe


def share_poses(nodes: Sequence[Any]) -> None:
    """Feed odometry and time to all layers of a drone from one subscription.

    Guidance comes last: its outputs reach a controller after its step, whether or not its round is complete.
    """
    if not nodes:
        return
    ordered = sorted(nodes, key=lambda node: isinstance(node, GuidanceNode))
    takers = [node.guarded(node.take_pose, ODOM.name) for node in ordered]
    leader: LayerNode = nodes[0]
    for node in nodes[1:]:
        node.share_time(leader)
    leader.be_told_time()

    def take(pose: Pose) -> None:
        if pose.time is not None:
            leader.tell_time(pose.time)
        for taker in takers:
            taker(pose)

    pose_subscribe("pubsub", ODOM.name, leader, take)


def share_references(nodes: Sequence[Any]) -> None:
    """Pass references to the controller of a drone by direct calls; other nodes receive them on their topic."""
    for controller in nodes:
        subscription = getattr(controller, "reference_subscription", None)
        if not isinstance(controller, CrazyflieController) or subscription is None:
            continue
        sources = [
            node
            for node in nodes
            if hasattr(node, "reference_publisher") and node.reference_publisher.topic_name == subscription.topic_name
        ]
        for node in sources:
            node.reference_publisher = _Shared(node.reference_publisher, subscription.callback)
        if sources:
            controller.destroy_subscription(subscription)


class _Shared:
    """A publisher of bytes that also passes them to a callback in this process."""

    def __init__(self, publisher: Any, take: Callable[[bytes], None]) -> None:
        self._publisher, self._take = publisher, take
        self.topic_name: str = publisher.topic_name

    def publish(self, data: bytes) -> None:
        """Publish a message, and hand it over."""
        self._publisher.publish(data)
        self._take(data)
