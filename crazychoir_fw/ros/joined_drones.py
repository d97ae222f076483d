"""The drones of a flight in other processes: pose and state, from its host, or else from the drones' own topics."""

from __future__ import annotations

import time as wall
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import BatteryState
from std_msgs.msg import String

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.access import DroneState
from crazychoir_fw.flight.agents import names_of, starts_of
from crazychoir_fw.ros import arming_services
from crazychoir_fw.ros.names import CF_ODOM, ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe

NEWEST = QoSProfile(depth=1, reliability=QoSReliabilityPolicy.BEST_EFFORT)
"""For topics of which only the newest message counts."""

_SELF_TOLD_S = 1.0  # [s], wall: age of ``odom`` from which ``cf_odom`` is used


class JoinedDrones:
    """The drones of a joined flight, as the page sees a backend."""

    is_real_time = True
    """The page does not control time."""
    is_over_ros = True

    def __init__(
        self,
        node: LayerNode,
        mission: Any,
        close: Callable[[], None],
        spin: Callable[[], None] = lambda: None,
        stop_now: Callable[[list[int]], None] = lambda indices: None,
    ) -> None:
        """Know where the drones of a mission begin.

        Args:
            node: Node that subscribes.
            mission: The mission flown.
            close: Leaves the flight.
            spin: Spins the node once, while a call waits for its response.
            stop_now: Presses STOP of drones, from any thread.
        """
        self._node, self._spin = node, spin
        self.names = names_of(mission)
        self.close, self.stop_now = close, stop_now
        self.domain = node.context.get_domain_id()
        self.states = [DroneState(link="not heard yet") for _ in self.names]
        self.time = 0.0
        self.heard_wall = -np.inf
        """Time of the latest message of any of them (s, wall)."""
        self.is_silent = False
        count = len(self.names)
        position = np.array(starts_of(mission), float).reshape(count, 3)
        orientation = np.tile((0.0, 0.0, 0.0, 1.0), (count, 1))
        # until its first message a drone is at its start of the mission
        self._pose = Pose(position, orientation, np.zeros((count, 3)), np.zeros((count, 3)), 0.0)
        self._odom_wall = np.full(count, -np.inf)

    def poses(self) -> Pose:
        """Return the latest poses received, arrays of shape (N, ...)."""
        return self._pose

    def place(self, i: int, pose: Pose) -> None:
        """Store the pose of a drone; fields with NaN or infinity are ignored."""
        self.heard_wall = wall.monotonic()
        for name in ("position", "orientation", "velocity", "angular"):
            new = getattr(pose, name)
            if new is not None and np.isfinite(new).all():
                getattr(self._pose, name)[i] = new
        if pose.time is not None:
            self.time = self._pose.time = pose.time

    def watch_topics(self) -> None:
        """Subscribe to odometry, battery and radio state of each drone, where no host publishes states."""
        for i in range(len(self.names)):
            for topic in (ODOM, CF_ODOM):
                where, take = self._node.topic_of(i, topic.name), self._pose_taker(i, topic is ODOM)
                pose_subscribe("pubsub", where, self._node, take, qos_profile=NEWEST)
            self._watch_radio(i)

    def _pose_taker(self, i: int, is_odom: bool) -> Callable[[Pose], None]:
        def take(pose: Pose) -> None:
            # the drone's own estimate is used while there is no ``odom``
            if is_odom or wall.monotonic() - self._odom_wall[i] > _SELF_TOLD_S:
                self.place(i, pose)
            if is_odom:
                self._odom_wall[i] = wall.monotonic()

        return take

    def _watch_radio(self, i: int) -> None:
        def change(**news: Any) -> None:
            self.states[i] = replace(self.states[i], **news)

        node = self._node
        change(link="over ROS 2")
        node.create_subscription(
            BatteryState, node.topic_of(i, "battery"), lambda m: change(battery_v=float(m.voltage)), NEWEST
        )
        node.create_subscription(String, node.topic_of(i, "radio_state"), lambda m: change(link=m.data), 10)

    def state(self, index: int) -> DroneState:
        """Return the state of a drone, as far as it was received."""
        state = self.states[index]
        return DroneState(state.supervisor, state.battery_v, link="silent") if self.is_silent else state

    @property
    def is_cared_for(self) -> bool:
        """Whether a node serves ``arm`` for drones."""
        return bool(arming_services.served_on(self._node, arming_services.ARM))

    def arm(self, index: int, is_armed: bool) -> None:
        """Request to arm or disarm a drone.

        Raises:
            StateError: If the request fails; the text gives the reason.
        """
        self._ask_for(index, arming_services.ARM, is_armed)

    def reboot(self, index: int) -> str:
        """Request the reboot of a drone; returns the message of the response. See `arm`."""
        return self._ask_for(index, arming_services.REBOOT)

    def _ask_for(self, index: int, name: str, is_armed: bool = False) -> str:
        service = self._node.topic_of(index, name)
        if service not in arming_services.served_on(self._node, name):
            raise StateError(f"{self.names[index]}: nobody serves {service}")
        return arming_services.ask_for(self._node, service, name, is_armed, self._spin)
