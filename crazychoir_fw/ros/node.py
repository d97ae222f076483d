"""`LayerNode`: what all nodes have in common."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import ClockChange, JumpThreshold, TimeJump
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.ros.conversions import from_bytes, to_stamp
from crazychoir_fw.ros.names import BUTTONS, CLOCK, NAMESPACE_PATTERN, Topic
from crazychoir_fw.ros.periodic import Periodic, check_frequency

_WARN_EVERY = 1.0  # [s]

_TYPES: Mapping[Any, Parameter.Type] = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
    list[bool]: Parameter.Type.BOOL_ARRAY,
    list[int]: Parameter.Type.INTEGER_ARRAY,
    list[float]: Parameter.Type.DOUBLE_ARRAY,
    list[str]: Parameter.Type.STRING_ARRAY,
}


class LayerNode(Node):
    """A node of one drone: fixed name, namespace ``agent_{i}``, declared parameters, work on the clock of ROS.

    The drone is, in this order, the argument `agent_id`, the parameter ``agent_id``, the number in the namespace that
    was given on the command line (``-r __ns:=/agent_3``), or 0. A namespace of the command line is always kept.
    """

    def __init__(
        self,
        node_name: str,
        *,
        agent_id: int | None = None,
        namespace_pattern: str = NAMESPACE_PATTERN,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
        swarm_wide: bool = False,
    ) -> None:
        """Create the node.

        Args:
            node_name: Its fixed name, such as "controller".
            agent_id: Number of the drone; None asks parameter and namespace.
            namespace_pattern: Namespace of drone i; the parameter ``namespace_pattern`` comes before it.
            parameters: Values of parameters, as given on the command line; lists may mix whole numbers and others,
                and arrays are laid out row by row. ``{"use_sim_time": True}`` follows ``/clock``.
            context: Context of rclpy; None is the default one.
            swarm_wide: The node serves all drones: it is in the root namespace, and `agent_id` is -1.

        Raises:
            RangeError: If the pattern or a parameter is not usable.
        """
        values = {name: _plain(value) for name, value in (parameters or {}).items()}
        if agent_id is not None:
            values["agent_id"] = int(agent_id)
        overrides = [Parameter(name, value=value) for name, value in values.items() if value is not None]
        space, given_id, namespace_pattern = "", -1, values.get("namespace_pattern", namespace_pattern)
        if not swarm_wide:
            space, given_id, namespace_pattern = _place(node_name, values.get("agent_id"), namespace_pattern, context)
        super().__init__(node_name, namespace=space, context=context, parameter_overrides=overrides)
        if not swarm_wide:
            self.declare("namespace_pattern", namespace_pattern, "namespace of drone i")
            given_id = self.declare("agent_id", given_id, "number of the drone", low=0)
        self.agent_id: int = given_id
        """Number of the drone."""
        self.namespace_pattern = namespace_pattern
        """Namespace of drone i."""
        self._periodics: list[Periodic] = []
        self._when_time_jumps_back: list[Callable[[float], None]] = []
        threshold = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=True)
        self._jumps = self.get_clock().create_jump_callback(threshold, post_callback=self._time_jumped)

    # ---------------------------------------------------------------- names

    def topic_of(self, agent_id: int, name: str) -> str:
        """Return the absolute name of a topic of another drone."""
        return f"/{self.namespace_pattern.format(i=agent_id)}/{name}"

    # ---------------------------------------------------------------- parameters

    def declare(
        self,
        name: str,
        default: Any,
        description: str,
        kind: Any = None,
        *,
        low: float | None = None,
        high: float | None = None,
        length: int | None = None,
    ) -> Any:
        """Declare a parameter that is read once, and return its value.

        Whole numbers are taken where floating-point ones are declared.

        Args:
            name: Name.
            default: Value of a parameter that is not set; None: no default, and None is returned.
            description: What ``ros2 param describe`` says; with units.
            kind: bool, int, float, str, or a list of one of them, such as ``list[float]``; None is that of the default.
            low: Minimum allowed.
            high: Largest allowed number.
            length: Length that a list must have.

        Raises:
            RangeError: If the value given is of another type, or outside its range.
        """
        kind = _kind_of(default) if kind is None else kind
        # declared without a type first, since rclpy would refuse 1 where 1.0 is meant
        value = self.declare_parameter(name, None, ParameterDescriptor(dynamic_typing=True)).value
        self.undeclare_parameter(name)
        value = default if value is None else self._checked(name, value, kind, low, high, length)
        descriptor = ParameterDescriptor(description=description, read_only=True)
        if kind is int and (low is not None or high is not None):
            limits = (-(2**63) if low is None else int(low), 2**63 - 1 if high is None else int(high))
            descriptor.integer_range = [IntegerRange(from_value=limits[0], to_value=limits[1], step=1)]
        elif kind is float and (low is not None or high is not None):
            limits = (-math.inf if low is None else float(low), math.inf if high is None else float(high))
            descriptor.floating_point_range = [FloatingPointRange(from_value=limits[0], to_value=limits[1])]
        if value is None:
            self.declare_parameter(name, _TYPES[kind], descriptor, ignore_override=True)
        else:
            self.declare_parameter(name, Parameter(name, _TYPES[kind], value).value, descriptor, ignore_override=True)
        return value

    def _checked(self, name: str, value: Any, kind: Any, low: float | None, high: float | None, length: int | None):
        try:
            converted = _converted(value, kind)
            numbers = converted if isinstance(converted, list) else [converted]
            too_low = low is not None and any(not number >= low for number in numbers)
            too_high = high is not None and any(not number <= high for number in numbers)
            if too_low or too_high or (length is not None and len(numbers) != length):
                raise ValueError
        except (TypeError, ValueError):
            allowed = getattr(kind, "__name__", str(kind)) if not isinstance(kind, type(list[int])) else str(kind)
            allowed += "" if length is None else f" of {length}"
            allowed += "" if low is None else f", {low:g} or more"
            allowed += "" if high is None else f", {high:g} or less"
            who = f"{self.get_fully_qualified_name()}: parameter {name}"
            raise RangeError(f"{who} is {value!r}, allowed: {allowed}") from None
        return converted

    # ---------------------------------------------------------------- time

    def now(self) -> float:
        """Return the time of the clock of ROS (s): simulated time if ``use_sim_time`` is set."""
        return self.get_clock().now().nanoseconds / 1e9

    @property
    def is_simulated_time(self) -> bool:
        """Whether the node follows ``/clock``."""
        return bool(self.get_parameter("use_sim_time").value)

    def share_time(self, other: LayerNode) -> None:
        """Have the time of another node of this process."""
        self._time_source.detach_node()
        other._time_source.attach_clock(self.get_clock())

    def be_told_time(self) -> None:
        """Follow `tell_time` instead of ``/clock``, with all nodes that share the time of this one."""
        self._time_source.detach_node()

    def tell_time(self, time: float) -> None:
        """Set the time of the node (s), as a message on ``/clock`` would."""
        self._time_source.clock_callback(CLOCK.type(clock=to_stamp(time)))

    def every(self, frequency: float, work: Callable[[float], None]) -> Periodic:
        """Call ``work(now)`` so many times per second of the clock of ROS.

        It is called on a grid, so that it does not drift; missed calls are not made up for; where time jumps back, a
        new grid begins.

        Args:
            frequency: Calls per second (Hz).
            work: Called with the time (s).

        Raises:
            RangeError: If the frequency is not above zero.
        """
        check_frequency(self.get_name(), frequency)
        periodic = Periodic(self, frequency, work)
        self._periodics.append(periodic)
        return periodic

    def skip_ticks(self) -> None:
        """Leave out calls of `every` that are due: the next ones are a period from now."""
        for periodic in self._periodics:
            periodic.skip()

    def when_time_jumps_back(self, callback: Callable[[float], None]) -> None:
        """Call ``callback(now)`` when simulated time jumps back, or another clock is used, to reset state."""
        self._when_time_jumps_back.append(callback)

    def _time_jumped(self, jump: TimeJump) -> None:
        changed = jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED)
        if not changed and jump.delta.nanoseconds >= 0:
            return
        for periodic in self._periodics:
            periodic.reset()
        now = self.now()
        for callback in self._when_time_jumps_back:
            callback(now)

    # ---------------------------------------------------------------- topics

    def announce(self, topic: Topic, name: str | None = None) -> Publisher:
        """Return a publisher for a line of the table, under another name if one is given."""
        return self.create_publisher(topic.type, name or topic.name, topic.publish_qos)

    def complain(self, topic: str, error: CrazychoirError) -> None:
        """Log the error of a message, at most once per second."""
        self.get_logger().warning(f"{topic}: {error}", throttle_duration_sec=_WARN_EVERY)

    def listen(
        self,
        topic: Topic,
        callback: Callable[[Any], None],
        name: str | None = None,
        *,
        profile: QoSProfile | None = None,
        callback_group: CallbackGroup | None = None,
        fast: bool = False,
    ) -> Subscription:
        """Subscribe to a line of the table.

        A message that the callback rejects with an error of this package is logged, at most once per second, and
        dropped: messages of other nodes must not end this node.

        Args:
            topic: The line.
            callback: Takes each message.
            name: Name, if not that of the table.
            profile: Quality of service, if not that of the table.
            callback_group: Callback group of rclpy.
            fast: The callback takes what `from_bytes` returns, instead of a message of rclpy.
        """
        if fast:
            return self.listen_to_bytes(
                topic,
                lambda data: callback(from_bytes(data, topic.type)),
                name,
                profile=profile,
                callback_group=callback_group,
            )
        return self._subscribe(topic, callback, name, profile, callback_group, raw=False)

    def listen_to_bytes(
        self,
        topic: Topic,
        callback: Callable[[bytes], None],
        name: str | None = None,
        *,
        profile: QoSProfile | None = None,
        callback_group: CallbackGroup | None = None,
    ) -> Subscription:
        """Subscribe to a line of the table as `listen` does; the callback takes messages as bytes."""
        return self._subscribe(topic, callback, name, profile, callback_group, raw=True)

    def _subscribe(
        self,
        topic: Topic,
        callback: Callable[[Any], None],
        name: str | None,
        profile: QoSProfile | None,
        callback_group: CallbackGroup | None,
        raw: bool,
    ) -> Subscription:
        name = name or topic.name
        profile = topic.subscribe_qos if profile is None else profile
        guarded = self.guarded(callback, name)
        return self.create_subscription(topic.type, name, guarded, profile, callback_group=callback_group, raw=raw)

    def guarded(self, callback: Callable[[Any], None], name: str) -> Callable[[Any], None]:
        """Wrap a callback, so that errors of this package are logged with the name of a topic."""

        def guarded(message: Any) -> None:
            try:
                callback(message)
            except CrazychoirError as error:
                self.complain(name, error)

        return guarded

    def on_buttons(self, **callbacks: Callable[[float], None]) -> None:
        """Listen to swarm-wide buttons.

        Args:
            callbacks: ``takeoff``, ``land``, ``stop`` or ``start``, called with the time (s).

        Raises:
            RangeError: If there is no such button.
        """
        for button, callback in callbacks.items():
            if button not in BUTTONS:
                raise RangeError(f"button is {button!r}, allowed: {', '.join(BUTTONS)}")
            self.listen(BUTTONS[button], lambda _, pressed=callback: pressed(self.now()))


def _place(node_name: str, agent_id: int | None, pattern: str, context: Context | None) -> tuple[str, int, str]:
    """Return namespace, number of the drone and pattern, as far as they can be known before the node exists."""
    if agent_id is not None:
        return _namespace(pattern, agent_id), agent_id, pattern
    # arguments of the command line are known only to a node: read them from a temporary one
    probe = Node(
        node_name,
        context=context,
        enable_rosout=False,
        start_parameter_services=False,
        automatically_declare_parameters_from_overrides=True,
    )
    try:
        space = probe.get_namespace()
        said = {name: probe.get_parameter_or(name).value for name in ("agent_id", "namespace_pattern")}
    finally:
        probe.destroy_node()
    pattern = said["namespace_pattern"] or pattern
    number = said["agent_id"]
    if number is None:
        found = re.fullmatch("/" + re.escape(pattern).replace(r"\{i\}", r"(\d+)"), space)
        number = int(found[1]) if found else 0
    return _namespace(pattern, number), number, pattern


def _namespace(pattern: str, agent_id: int) -> str:
    if not isinstance(pattern, str) or pattern.count("{i}") != 1 or re.search(r"[{}]", pattern.replace("{i}", "")):
        raise RangeError(f"namespace_pattern is {pattern!r}, allowed: a name with {{i}} in it, such as agent_{{i}}")
    if isinstance(agent_id, bool) or not isinstance(agent_id, int) or agent_id < 0:
        raise RangeError(f"agent_id is {agent_id!r}, allowed: a whole number, 0 or more")
    return pattern.format(i=agent_id)


def _plain(value: Any) -> Any:
    """Return arrays of NumPy as flat lists, row by row, and mixed lists of numbers as such of floating-point ones."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.ravel().tolist() if value.ndim else value.item()
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        value = list(value)
        if any(isinstance(item, float) for item in value):
            value = [float(item) for item in value]
    return value


def _kind_of(default: Any) -> Any:
    if isinstance(default, list):
        return list[type(default[0])] if default else list[str]  # type: ignore[misc]
    return type(default)


def _converted(value: Any, kind: Any) -> Any:
    if kind in (bool, int, str):
        if type(value) is not kind:
            raise TypeError
        return value
    if kind is float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise TypeError
        return float(value)
    item = kind.__args__[0]
    if isinstance(value, str | bytes):
        raise TypeError
    return [_converted(entry, item) for entry in value]
