"""The buttons of a swarm, on topics and as services: take-off, land, stop, start.

``/takeoff``, ``/land``, ``/stop`` and ``/experiment_trigger`` are topics of `std_msgs/Empty`; the node `Buttons` serves
`std_srvs/Trigger` under the same names, for clients that need a response.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.utilities import try_shutdown
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from crazychoir_fw.common.errors import StateError, UnknownNameError
from crazychoir_fw.ros.names import BUTTONS
from crazychoir_fw.ros.node import LayerNode


def serve_trigger(node: Node, name: str, work: Callable[[], None], message: str) -> Any:
    """Serve a `std_srvs/Trigger` that calls `work` and responds with `message`."""

    def answer(_: Any, response: Any) -> Any:
        work()
        response.success, response.message = True, message
        return response

    return node.create_service(Trigger, name, answer)


class Buttons(LayerNode):
    """Publishes the swarm-wide buttons, on calls of its methods and of its services."""

    def __init__(self, *, services: bool = True, context: Context | None = None) -> None:
        """Make the node ``buttons``.

        Args:
            services: Whether the buttons are served as services, too.
            context: Context of rclpy.
        """
        super().__init__("buttons", swarm_wide=True, context=context)
        self._publishers_of = {name: self.announce(topic) for name, topic in BUTTONS.items()}
        if services:
            for name, topic in BUTTONS.items():
                serve_trigger(self, topic.name, partial(self.press, name), f"{topic.name} pressed")

    def press(self, button: str) -> None:
        """Press a button: ``takeoff``, ``land``, ``stop`` or ``start``.

        Raises:
            UnknownNameError: If there is no such button.
        """
        if button not in self._publishers_of:
            raise UnknownNameError(f"button is {button!r}, allowed: {', '.join(self._publishers_of)}")
        self._publishers_of[button].publish(Empty())

    def listeners(self, button: str) -> int:
        """Return how many nodes listen to a button."""
        return int(self._publishers_of[button].get_subscription_count())

    def press_when_heard(self, button: str, timeout: float = 5.0, settle: float = 0.3, urgent: bool = False) -> int:
        """Wait for a subscriber, and press a button once. Returns the number of subscribers.

        Args:
            button: Which one.
            timeout: Longest wait for the first subscriber (s, wall clock).
            urgent: Whether it is pressed at once for the first subscriber, and again for each one discovered later.
            settle: Time without a new subscriber after which discovery counts as complete (s, wall clock).

        Raises:
            StateError: If no node subscribes before the timeout.
        """
        deadline = time.monotonic() + timeout
        count, since = 0, time.monotonic()
        while True:
            now = time.monotonic()
            found = self.listeners(button)
            if found != count:
                count, since = found, now
                if urgent:
                    self.press(button)
            if count and now - since >= settle:
                break
            if now >= deadline:
                if count:
                    break
                raise StateError(f"nobody listens to {BUTTONS[button].name} on this ROS domain")
            time.sleep(0.02)
        if not urgent:
            self.press(button)
        self._publishers_of[button].wait_for_all_acked()
        return count


def press_once(button: str, domain: int | None = None, timeout: float = 5.0) -> int:
    """Press a button from a process that has no nodes otherwise. Returns the number of subscribers.

    Args:
        button: ``takeoff``, ``land``, ``stop`` (pressed at once) or ``start``.
        domain: ROS domain; None is that of ``ROS_DOMAIN_ID``.
        timeout: Longest wait for the first subscriber (s, wall clock).

    Raises:
        StateError: If no node subscribes before the timeout.
        UnknownNameError: If there is no such button.
    """
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    try:
        return Buttons(services=False, context=context).press_when_heard(button, timeout, urgent=button == "stop")
    finally:
        try_shutdown(context=context)
