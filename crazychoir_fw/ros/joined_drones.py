"""The drones of a flight that others fly: where they are, and how.

Where they are is what their odometry says.
"""

from __future__ import annotations

import time as wall
from collections.abc import Callable
from typing import Any

import numpy as np
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import BatteryState
from std_msgs.msg import String

from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.access import DroneState
from crazychoir_fw.flight.agents import names_of, starts_of
from crazychoir_fw.ros import arming_services
from crazychoir_fw.ros.names import CF_ODOM, ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.wire import odometry_pose

Array = NDArray[np.float64]

NEWEST = QoSProfile(depth=1, reliability=QoSReliabilityPolicy.BEST_EFFORT)
"""Of what is old when the next comes."""

_STAMPS_S = 1.0  # [s], wall, after which odometry without stamps has none


class JoinedDrones:
    """The drones of a joined flight, as the page sees a backend."""

    is_real_time = True
    """Time goes on whatever the page does."""
    is_over_ros = True

    def __init__(
        self,
        node: LayerNode,
        mission: Any,
        close: Callable[[], None],
        spin: Callable[[], None] = lambda: None,
        stop_now: Callable[[list[int]], None] = lambda indices: None,
    ) -> None:
        """Listen to each drone.

        Args:
            node: Who listens.
            mission: What is flown.
            close: Ends it.
            spin: Lets the node work for a moment, while somebody waits for an answer.
            stop_now: Presses STOP of drones, from any thread.
        """
        self._node, self._spin = node, spin
        self.names = names_of(mission)
        self.close, self.stop_now = close, stop_now
        self.domain = node.context.get_domain_id()
        self.states = [DroneState(link="not heard yet") for _ in self.names]
        self.trouble: str | None = None
        """Why this is not the flight of the mission, a sentence."""
        self.time = 0.0
        self.heard_wall = -np.inf
        self.first_wall = np.inf
        """When the first of them was heard (s, wall)."""
        self.is_heard = self.is_silent = False
        self._has_stamps = False
        self._said: dict[tuple[str, int], bytes] = {}
        count = len(self.names)
        position = np.array(starts_of(mission), float).reshape(count, 3)
        orientation = np.tile((0.0, 0.0, 0.0, 1.0), (count, 1))
        # who is not heard yet stands where the mission has it
        self._pose = Pose(position, orientation, np.zeros((count, 3)), np.zeros((count, 3)), 0.0)
        for i in range(count):
            for topic in (ODOM, CF_ODOM):
                node.create_subscription(
                    Odometry, node.topic_of(i, topic.name), self._odometry_taker((topic.name, i)), NEWEST, raw=True
                )

    def poses(self) -> Pose:
        """Return where they were heard last, arrays of shape (N, ...)."""
        return self._pose

    def state(self, index: int) -> DroneState:
        """Return how a drone is, as far as the host tells."""
        state = self.states[index]
        return DroneState(state.supervisor, state.battery_v, link="silent") if self.is_silent else state

    @property
    def is_cared_for(self) -> bool:
        """Whether somebody arms and reboots drones."""
        return bool(arming_services.served_on(self._node, arming_services.ARM))

    def arm(self, index: int, is_armed: bool) -> None:
        """Ask for a drone to be armed or disarmed.

        Raises:
            StateError: If it is not; the text says why.
        """
        self._ask_for(index, arming_services.ARM, is_armed)

    def reboot(self, index: int) -> str:
        """Ask for a drone to be rebooted; returns what to expect. See `arm`."""
        return self._ask_for(index, arming_services.REBOOT)

    def _ask_for(self, index: int, name: str, is_armed: bool = False) -> str:
        service = self._node.topic_of(index, name)
        if service not in arming_services.served_on(self._node, name):
            raise StateError(f"{self.names[index]}: nobody serves {service}")
        return arming_services.ask_for(self._node, service, name, is_armed, self._spin)

    def watch_radio(self, i: int) -> None:
        """Listen to what radio nodes say of a drone."""

        def change(**news: Any) -> None:
            state = self.states[i]
            known = {"supervisor": state.supervisor, "battery_v": state.battery_v, "link": state.link}
            self.states[i] = DroneState(**{**known, **news})

        node = self._node
        change(link="over ROS 2")
        node.create_subscription(
            BatteryState, node.topic_of(i, "battery"), lambda m: change(battery_v=float(m.voltage)), NEWEST
        )
        node.create_subscription(String, node.topic_of(i, "radio_state"), lambda m: change(link=m.data), 10)

    def _odometry_taker(self, key: tuple[str, int]) -> Callable[[bytes], None]:
        def take(data: bytes) -> None:
            self._said[key] = data
            self.heard_wall = wall.monotonic()
            self.first_wall = min(self.first_wall, self.heard_wall)

        return take

    def refresh(self) -> bool:
        """Take what has been heard; returns whether time has jumped back, as when a flight begins anew."""
        before = self.time
        said, self._said = self._said, {}
        # what drones over the radio say of themselves is used where nothing better is known
        for (name, i), data in sorted(said.items()):
            try:
                pose = odometry_pose(data)
            except CrazychoirError as error:
                self._node.complain(self._node.topic_of(i, name), error)
                continue
            if name == CF_ODOM.name and (ODOM.name, i) in said:
                continue
            self._place([i], np.concatenate([pose.position, pose.orientation, pose.velocity, pose.angular])[None])
            if pose.time is not None:
                self.time, self._has_stamps = pose.time, True
            elif not self._has_stamps and wall.monotonic() - self.first_wall > _STAMPS_S:
                self.time = wall.monotonic() - self.first_wall  # the odometry of some nodes has no stamps
        self._pose.time = self.time
        return self.time < before - 1.0

    def _place(self, which: Any, numbers: Array) -> None:
        """Put numbers of odometry where they belong; those that are none change nothing."""
        self.is_heard = True
        pose = self._pose
        parts = (pose.position, pose.orientation, pose.velocity, pose.angular)
        good = np.isfinite(numbers).all(axis=1)
        for part, new in zip(parts, np.split(numbers, (3, 7, 10), axis=1), strict=True):
            old = part[which]
            part[which] = np.where(good[:, None], new, old)
