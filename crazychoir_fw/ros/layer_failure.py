"""A layer that raises in a node: reported once, by topic and log. The node runs on without it; the drone is landed."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import TracebackType
from typing import Any

from rclpy.node import Node
from std_msgs.msg import String

from crazychoir_fw.common.user_code import USER_ERRORS, describe
from crazychoir_fw.ros.names import FAILURE, LATEST

_LONGEST = 300  # characters kept of a reason received from another node


class LayerGuard:
    """A context around each call of a layer: suppresses what a user's code raises, and reports it.

    The error goes to ``failure`` (`std_msgs/String`, latched) in the namespace of the drone, as JSON: the name ``node``
    and ``reason``, a sentence with class, error, file and line. Hosts of flights and `RadioHandler` nodes land the
    drone.
    """

    def __init__(self, node: Node, layer: object, when_failed: Callable[[], None] = lambda: None) -> None:
        """Guard a layer of a node; `when_failed` is called after its first error."""
        self._node, self._name, self._when_failed = node, type(layer).__name__, when_failed
        # made before it is needed: another participant may take seconds to discover a publisher
        self._publisher = node.create_publisher(String, FAILURE, LATEST)
        self.failure: str | None = None
        """The first error, as a sentence; None while there is none."""

    def __enter__(self) -> None:
        """Begin a call."""

    def __exit__(self, kind: Any, error: BaseException | None, trace: TracebackType | None) -> bool:
        """End a call; True suppresses the error."""
        if not isinstance(error, USER_ERRORS):
            return False
        if self.failure is None:
            self.failure = f"{self._name}: {describe(error)}"
            told = {"node": self._node.get_name(), "reason": self.failure}
            self._publisher.publish(String(data=json.dumps(told)))
            self._node.get_logger().error(f"{self.failure}; the drone is to land, this layer does nothing any more")
            self._when_failed()
        return True


def heard_failure(message: String) -> tuple[str, str]:
    """Return node and reason, one printable line, of a message on ``failure``, which may come from any participant."""
    try:
        told = json.loads(message.data)
        node, reason = str(told["node"]), str(told["reason"])
    except (ValueError, KeyError, TypeError, RecursionError):
        node, reason = "", f"a layer has failed: {message.data}"
    line = " ".join(reason[:_LONGEST].split())
    return node, "".join(character for character in line if character.isprintable())
