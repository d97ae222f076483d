"""`TopicPoses`: poses of real bodies out of topics, for experiments that are no nodes themselves."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.utilities import try_shutdown

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe


class TopicPoses:
    """A source of poses (`crazychoir_fw.mocap.sources.PoseSource`) with a node ``mocap_source`` of its own.

    Bodies are called as their topics, such as ``/vicon/cf1/cf1``.
    """

    def __init__(
        self,
        topics: Sequence[str],
        handler: str = "pose",
        *,
        clock: Callable[[], float] = time.monotonic,
        context: Context | None = None,
    ) -> None:
        """Subscribe.

        Args:
            topics: Names of the topics.
            handler: Kind of their messages, see `crazychoir_fw.ros.pose_sources`.
            clock: Time of arrival (s).
            context: Context of rclpy; None makes one.
        """
        self._owns = context is None
        self._context = Context() if context is None else context
        if self._owns:
            rclpy.init(args=[], context=self._context)
        self._node = LayerNode("mocap_source", swarm_wide=True, context=self._context)
        self._clock = clock
        self._latest: dict[str, Pose] = {}
        self._lock = threading.Lock()
        for topic in topics:
            pose_subscribe(handler, topic, self._node, self._taker(topic))
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="poses of topics", daemon=True)
        self._thread.start()

    def _taker(self, topic: str) -> Callable[[Pose], None]:
        def take(pose: Pose) -> None:
            # stamps may be those of another computer
            arrived = replace(pose, time=self._clock())
            with self._lock:
                self._latest[topic] = arrived

        return take

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self._executor.spin()

    def latest(self) -> dict[str, Pose]:
        """Return the newest pose of each topic, without waiting."""
        with self._lock:
            return dict(self._latest)

    def close(self, *_: Any) -> None:
        """End the subscriptions."""
        self._executor.shutdown()
        self._thread.join(1.0)
        self._node.destroy_node()
        if self._owns:
            try_shutdown(context=self._context)
