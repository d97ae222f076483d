"""Markers for RViz: where drones are, were and should be (docs/reference/crazychoir.md#11).

Frame `world`, which is the fixed frame of the configuration `rviz_config`, needs no broadcast.
"""

from __future__ import annotations

import colorsys
import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from numpy.typing import NDArray
from rclpy.context import Context
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import message_to_reference
from crazychoir_fw.ros.names import FULLSTATE, MARKER, MARKERS, NAMESPACE_PATTERN, POSITION, WORLD_FRAME
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe

SHAPES = ("sphere", "arrow")
_DIAMETER = 0.2  # [m], docs/reference/crazychoir.md#11
_ARROW = (0.24, 0.04, 0.04)  # [m]
_LINE = 0.01  # [m]
_NAME = 0.08  # [m], height of letters
_TRAIL_STEP = 0.02  # [m], between points of a trail
_RED = ColorRGBA(r=1.0, g=0.0, b=0.0, a=1.0)


def rviz_config() -> Path:
    """Return the configuration for ``rviz2 -d``: all markers, a grid, fixed frame `world`."""
    return Path(__file__).with_name("rviz") / "swarm.rviz"


class SimpleVisualizer(LayerNode):
    """Node ``visualizer`` of one drone: a red sphere on ``/visualization_marker``."""

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        update_frequency: float = 25.0,
        *,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            pose_handler: Where poses come from, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the pose.
            update_frequency: Markers per second (Hz).
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters.
            context: Context of rclpy.
        """
        super().__init__("visualizer", agent_id=agent_id, parameters=parameters, context=context)
        self.current_pose = Pose()
        """The latest pose."""
        self._markers = self.announce(MARKER)
        self.pose_source = pose_subscribe(pose_handler, pose_topic, self, self.current_pose)
        self.every(update_frequency, self.publish_data)

    def publish_data(self, now: float) -> None:
        """Publish the marker; may be overridden."""
        if self.current_pose.position is not None:
            marker = _marker("robots", self.agent_id, Marker.SPHERE, _RED, self.get_clock().now().to_msg())
            marker.scale = Vector3(x=_DIAMETER, y=_DIAMETER, z=_DIAMETER)
            _place(marker, self.current_pose)
            self._markers.publish(marker)


class Visualizer(LayerNode):
    """Node ``visualizer`` of the whole swarm: drones, names, trails, references and edges in one message."""

    def __init__(
        self,
        agents: Sequence[int] | None = None,
        *,
        edges: Iterable[tuple[int, int]] = (),
        shape: str = "arrow",
        trail: float = 5.0,
        names: bool = True,
        pose_handler: str = "pubsub",
        pose_topic: str = "odom",
        update_frequency: float = 25.0,
        namespace_pattern: str = NAMESPACE_PATTERN,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            agents: Numbers of the drones; None is 0 to the parameter ``N``.
            edges: Pairs of drones between which lines are drawn; the parameter ``edges`` has them one behind the other.
            shape: ``sphere``, or ``arrow`` along body x, which shows the attitude.
            trail: How long a drone's path is shown (s); 0 is not at all.
            names: Whether names are shown.
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose, in the namespace of each drone.
            update_frequency: Messages per second (Hz).
            namespace_pattern: Namespace of drone i.
            parameters: Values of parameters.
            context: Context of rclpy.

        Raises:
            RangeError: If a value is outside its range.
        """
        super().__init__(
            "visualizer", swarm_wide=True, namespace_pattern=namespace_pattern, parameters=parameters, context=context
        )
        count = self.declare("N", 1, "number of drones", low=1)
        flat = [int(i) for pair in edges for i in pair]
        flat = self.declare("edges", flat or None, "pairs of drones with a line between them", list[int], low=0) or []
        self._shape = self.declare("shape", shape, "sphere or arrow")
        self._trail = self.declare("trail", float(trail), "how long the path of a drone is shown (s)", low=0.0)
        self._has_names = self.declare("names", names, "whether names are shown")
        self._agents = list(range(count) if agents is None else agents)
        if self._shape not in SHAPES:
            raise RangeError(f"visualizer: shape is {self._shape!r}, allowed: {', '.join(SHAPES)}")
        if len(flat) % 2 or not set(flat) <= set(self._agents):
            raise RangeError(f"visualizer: edges are {flat}, allowed: pairs of drones of {self._agents}")
        self._edges = list(zip(flat[::2], flat[1::2], strict=True))
        self._poses: dict[int, Pose] = {i: Pose() for i in self._agents}
        self._trails: dict[int, deque[tuple[float, NDArray[Any]]]] = {i: deque() for i in self._agents}
        self._wanted: dict[int, NDArray[Any]] = {}
        self._colors = {i: _color(k) for k, i in enumerate(self._agents)}
        self._publisher = self.announce(MARKERS)
        for i in self._agents:
            pose_subscribe(pose_handler, self.topic_of(i, pose_topic), self, self._poses[i])
            for topic, kind in ((FULLSTATE, "fullstate"), (POSITION, "position")):
                self.listen(topic, self._reference_taker(i, kind), self.topic_of(i, topic.name))
        self.when_time_jumps_back(self._begin_anew)
        self.every(update_frequency, self.publish_data)

    def _reference_taker(self, agent: int, kind: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            self._wanted[agent] = message_to_reference(message, kind).position  # type: ignore[assignment]

        return take

    def _begin_anew(self, now: float) -> None:
        self._wanted.clear()
        for agent in self._agents:
            self._trails[agent].clear()
            # filled in place by its subscription
            self._poses[agent].position = None

    # ---------------------------------------------------------------- markers

    def publish_data(self, now: float) -> None:
        """Publish all markers; may be overridden."""
        seen = [i for i in self._agents if self._poses[i].position is not None]
        if not seen:
            return
        stamp = self.get_clock().now().to_msg()
        markers = [self._drone(i, stamp) for i in seen]
        if self._has_names:
            markers += [self._name(i, stamp) for i in seen]
        if self._trail > 0.0:
            markers += [marker for i in seen if (marker := self._trail_of(i, now, stamp)) is not None]
        if self._wanted:
            markers.append(self._references(stamp))
        if self._edges:
            markers.append(self._lines(stamp))
        self._publisher.publish(MarkerArray(markers=markers))

    def _drone(self, agent: int, stamp: Time) -> Marker:
        is_arrow = self._shape == "arrow"
        kind = Marker.ARROW if is_arrow else Marker.SPHERE
        marker = _marker("robots", agent, kind, self._colors[agent], stamp)
        x, y, z = _ARROW if is_arrow else (_DIAMETER, _DIAMETER, _DIAMETER)
        marker.scale = Vector3(x=x, y=y, z=z)
        _place(marker, self._poses[agent])
        return marker

    def _name(self, agent: int, stamp: Time) -> Marker:
        marker = _marker("names", agent, Marker.TEXT_VIEW_FACING, ColorRGBA(r=0.9, g=0.9, b=0.9, a=1.0), stamp)
        marker.text = self.namespace_pattern.format(i=agent)
        marker.scale.z = _NAME
        marker.pose.position = _point(self._poses[agent].position)
        marker.pose.position.z += 0.5 * _DIAMETER + _NAME
        return marker

    def _trail_of(self, agent: int, now: float, stamp: Time) -> Marker | None:
        position, trail = self._poses[agent].position, self._trails[agent]
        while trail and trail[0][0] < now - self._trail:
            trail.popleft()
        if not trail or math.dist(trail[-1][1], position) > _TRAIL_STEP:
            trail.append((now, position))
        marker = _marker("trails", agent, Marker.LINE_STRIP, self._colors[agent], stamp)
        marker.scale.x = _LINE
        marker.points = [*(_point(past) for _, past in trail), _point(position)]
        return marker

    def _references(self, stamp: Time) -> Marker:
        marker = _marker("references", 0, Marker.SPHERE_LIST, _RED, stamp)
        marker.scale = Vector3(x=0.06, y=0.06, z=0.06)
        marker.points = [_point(position) for position in self._wanted.values()]
        marker.colors = [self._colors[agent] for agent in self._wanted]
        return marker

    def _lines(self, stamp: Time) -> Marker:
        marker = _marker("edges", 0, Marker.LINE_LIST, ColorRGBA(r=0.6, g=0.6, b=0.6, a=0.8), stamp)
        marker.scale.x = _LINE
        for pair in self._edges:
            ends = [self._poses[i].position for i in pair]
            if all(end is not None for end in ends):
                marker.points += [_point(end) for end in ends]
        return marker


def _marker(namespace: str, number: int, kind: int, color: ColorRGBA, stamp: Time) -> Marker:
    marker = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD, color=color)
    marker.header.frame_id = WORLD_FRAME
    marker.header.stamp = stamp
    # RViz warns about quaternions of zeros
    marker.pose.orientation.w = 1.0
    return marker


def _place(marker: Marker, pose: Pose) -> None:
    marker.pose.position = _point(pose.position)
    if pose.orientation is not None:
        x, y, z, w = pose.orientation.tolist()
        marker.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)


def _point(position: NDArray[Any] | None) -> Point:
    x, y, z = position.tolist()  # type: ignore[union-attr]
    return Point(x=x, y=y, z=z)


def _color(index: int) -> ColorRGBA:
    # steps of the golden ratio around the color wheel: neighbors never look alike, whatever the number
    r, g, b = colorsys.hsv_to_rgb((0.58 + 0.618034 * index) % 1.0, 0.75, 0.95)
    return ColorRGBA(r=r, g=g, b=b, a=1.0)
