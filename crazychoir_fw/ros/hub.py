"""`Hub`: what the nodes of one process share, so that a hundred of them cost little more than what they compute.

Each node by itself would follow ``/clock``, hear every odometry, and speak to its neighbors in the same process through
DDS. With a hub they have one clock, what one says the others have at once (`SharedPublisher`), and what the host of the
drones bundles for the whole process (`bundles`) is handed out in the order of the layers: all guidance, then all
planning, then all controllers, as in an experiment without ROS. The topics and subscriptions of every node exist
nevertheless: whoever speaks or listens from outside is heard, and hears.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from rclpy.time_source import TimeSource
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import String

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros import bundles
from crazychoir_fw.ros.bundles import FRESH_S, LOOK_EVERY, HostCard, MemberCard
from crazychoir_fw.ros.names import CLOCK, LATEST
from crazychoir_fw.ros.wire import MIN_NORM

if TYPE_CHECKING:
    from crazychoir_fw.ros.node import LayerNode
    from crazychoir_fw.ros.teams import GuidanceTeam

STAGES = 4
"""Guidance, planning, control, others."""

_LOOK_AT_WAITING = 0.05  # [s], wall: at rounds that wait
_ECHOES = 16  # messages of a topic that may come back


class Hub:
    """Clock, short cuts and bundles of the nodes of a process."""

    def __init__(self, name: str, lockstep: bool = False) -> None:
        """Make a hub without nodes.

        Args:
            name: Name of the process, for people.
            lockstep: Whether the host waits for all answers, so that they may wait for each other.
        """
        self.member = f"{name}#{os.getpid()}"
        """Under which it answers."""
        self.nanoseconds = 0
        """Time of the common clock (ns)."""
        self.now = 0.0
        """The same (s)."""
        self.is_working = False
        """Whether a bundle is being handed out, after which all rounds are looked at anyway."""
        self.looks = 0
        """Grows whenever it is time to look who listens."""
        self.clock = ROSClock()
        self._source = TimeSource()
        self._source.ros_time_is_active = True
        self._source.attach_clock(self.clock)
        self._lockstep = lockstep
        self._listeners: dict[str, list[Callable[[Any], None]]] = {}
        self._echoes: dict[str, deque[bytes]] = {}
        self._inlets: list[list[PoseInlet]] = [[] for _ in range(STAGES)]
        self._settling: list[list[Callable[[], None]]] = [[] for _ in range(STAGES)]
        self._periodics: list[list[HubPeriodic]] = [[] for _ in range(STAGES)]
        self._looking: list[Callable[[], None]] = []
        self._waiting: list[Callable[[], bool]] = []
        self._rows: dict[LayerNode, int | None] = {}
        self._said: list[bundles.Said] = []
        self._host: HostCard | None = None
        self._owes_answer = False
        self._announced = False
        self._bundle_wall = -np.inf
        self._look_wall = -np.inf
        self._carrier: LayerNode | None = None
        self.guidance_team: GuidanceTeam | None = None
        """Guidance that may decide for all nodes at once."""

    def add(self, node: LayerNode) -> None:
        """Take a node in; the first one carries the subscriptions of all."""
        if self._carrier is not None:
            return
        self._carrier = node
        best_effort = QoSProfile(depth=1, reliability=QoSReliabilityPolicy.BEST_EFFORT)
        node.create_subscription(ClockMessage, CLOCK.name, self._take_clock, best_effort)
        node.listen(bundles.ODOMETRY, self._take_odometry, raw=True)
        node.listen(bundles.HOST, lambda message: self._take_host(message.data), profile=LATEST)
        self._answers = node.announce(bundles.ANSWERS)
        self._members = node.create_publisher(String, bundles.MEMBERS.name, LATEST)
        self._odometry = next(s for s in node.subscriptions if s.topic_name == bundles.ODOMETRY.name)
        node.create_timer(_LOOK_AT_WAITING, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # ---------------------------------------------------------------- within the process

    def listeners(self, topic: str) -> list[Callable[[Any], None]]:
        """Return who of this process hears a topic (its absolute name); the list grows with them."""
        return self._listeners.setdefault(topic, [])

    def echoes(self, topic: str) -> deque[bytes]:
        """Return what has lately been said inside and outside: whoever heard it inside drops the copy from outside."""
        return self._echoes.setdefault(topic, deque(maxlen=_ECHOES))

    def pose_inlet(self, node: LayerNode, topic: str, take: Callable[[Pose], None], decode: Any) -> PoseInlet:
        """Return a subscription's callback for odometry as bytes, which bundles serve as well."""
        inlet = PoseInlet(self, node, topic, take, decode)
        self._inlets[node.stage].append(inlet)
        return inlet

    def row_of(self, node: LayerNode) -> int | None:
        """Return which row of the bundles is a node's own, if it takes its poses from there."""
        return self._rows.get(node)

    def periodic(self, node: LayerNode, frequency: float, work: Callable[[float], None]) -> HubPeriodic:
        """Return work at a rate on the common clock."""
        periodic = HubPeriodic(self, frequency, work)
        self._periodics[node.stage].append(periodic)
        return periodic

    def when_settling(
        self, node: LayerNode, callback: Callable[[], None], waits: Callable[[], bool] | None = None
    ) -> None:
        """Register a node whose rounds wait for others.

        Args:
            node: The node.
            callback: Called when all of its stage have their poses.
            waits: Whether a round is open; answers in lockstep wait for its end.
        """
        self._settling[node.stage].append(callback)
        if waits is not None:
            self._waiting.append(waits)

    def when_looking(self, callback: Callable[[], None]) -> None:
        """Have something called now and then by the clock on the wall, for rounds that wait."""
        self._looking.append(callback)

    def _look(self) -> None:
        self.looks += 1
        self._introduce()
        for callback in self._looking:
            callback()
        self._flush()

    # ---------------------------------------------------------------- time

    def _set_time(self, nanoseconds: int) -> None:
        self.nanoseconds, self.now = nanoseconds, nanoseconds / 1e9
        sec, nanosec = divmod(nanoseconds, 1_000_000_000)
        message = ClockMessage()
        message.clock.sec, message.clock.nanosec = sec, nanosec
        self._source.clock_callback(message)

    def _take_clock(self, message: ClockMessage) -> None:
        if self.has_host:
            return  # bundles bring the time; a copy may be late
        self._set_time(message.clock.sec * 1_000_000_000 + message.clock.nanosec)
        self._hand_out(None)

    @property
    def has_host(self) -> bool:
        """Whether bundles come."""
        return time.monotonic() - self._bundle_wall < FRESH_S

    # ---------------------------------------------------------------- bundles

    def host_hears(self, topic: str) -> int:
        """Return how many subscriptions of the host on a topic are served by bundles."""
        return 0 if self._host is None or not self.has_host else self._host.hears.get(topic, 0)

    def say(self, topic: str, data: bytes) -> None:
        """Put a message of a topic into the next bundle for the host."""
        self._said.append((topic, data))
        if not self.is_working:
            self._flush()

    def _take_host(self, text: str) -> None:
        card = HostCard.read(text)
        rows = {topic: row for row, topic in enumerate(card.odometry)}
        for stage in self._inlets:
            for inlet in stage:
                inlet.row = rows.get(inlet.topic)
                self._rows[inlet.node] = inlet.row
        self._host, self._announced = card, False
        self._introduce()

    def _introduce(self) -> None:
        """Tell the host which subscriptions it need not serve one by one, once it reaches this process."""
        if self._announced or self._host is None:
            return
        if self._odometry.get_publisher_count() and self._answers.get_subscription_count():
            served = {CLOCK.name: 1}
            for stage in self._inlets:
                for inlet in stage:
                    if inlet.row is not None:
                        served[inlet.topic] = served.get(inlet.topic, 0) + 1
            self._members.publish(String(data=MemberCard(self.member, served).text()))
            self._announced = True

    def _take_odometry(self, data: bytes) -> None:
        if self._host is None:
            return
        nanoseconds, rows = bundles.unpack_odometry(data)
        if len(rows) != len(self._host.odometry):
            raise RangeError(f"{len(rows)} drones, allowed: {len(self._host.odometry)}, as the host said")
        wall = time.monotonic()
        self._bundle_wall = wall
        if wall - self._look_wall >= LOOK_EVERY:
            self._look_wall = wall
            self.looks += 1
        self._set_time(nanoseconds)
        self._owes_answer = True
        self._hand_out(rows)

    def _hand_out(self, rows: np.ndarray | None) -> None:
        """Let all work, in the order of the layers."""
        now, good, turned = self.now, None, None
        if rows is not None:
            norms = np.sqrt(np.einsum("ij,ij->i", rows[:, 3:7], rows[:, 3:7]))
            # one look at the sums finds what is not finite in any of the numbers
            good = (np.isfinite(rows.sum(axis=1)) & (norms >= MIN_NORM)).tolist()
            turned = rows[:, 3:7] / norms[:, None]
            turned.flags.writeable = False
        self.is_working = True
        try:
            stages = list(zip(self._inlets, self._settling, self._periodics, strict=True))
            team = self.guidance_team
            if team is not None and rows is not None and team.work(rows, turned, good, now):
                stages = stages[1:]
            for inlets, settling, periodics in stages:
                if rows is not None:
                    for inlet in inlets:
                        row = inlet.row
                        if row is not None and good[row]:
                            own = rows[row]
                            inlet.hand(Pose(own[:3], turned[row], own[7:10], own[10:], now))
                for callback in settling:
                    callback()
                for periodic in periodics:
                    periodic.tick()
        finally:
            self.is_working = False
        self._flush()

    def _flush(self) -> None:
        """Send what the host is to hear, unless it would wait for the rest anyway."""
        if not (self._said or self._owes_answer) or self.is_working:
            return
        if self._lockstep and any(waits() for waits in self._waiting):
            return
        said, self._said, self._owes_answer = self._said, [], False
        self._answers.publish(bundles.pack_answers(self.nanoseconds, self.member, said))


class PoseInlet:
    """Where poses come into a node: from bundles, or as bytes of odometry; each once."""

    def __init__(self, hub: Hub, node: LayerNode, topic: str, take: Callable[[Pose], None], decode: Any) -> None:
        """Bind a node's callback to a topic (its absolute name)."""
        self.node, self.topic, self._take, self._decode = node, topic, take, decode
        self._hub = hub
        self.row: int | None = None
        """Which row of the bundle it is."""
        self._latest: float | None = None

    def __call__(self, data: bytes) -> None:
        """Take odometry as bytes."""
        if self.row is not None and self._hub.has_host:
            return  # a copy of what came in a bundle
        pose = self._decode(data)
        if pose.time is None or pose.time != self._latest:
            self._latest = pose.time
            self._take(pose)

    def hand(self, pose: Pose) -> None:
        """Take a pose out of a bundle."""
        if pose.time == self._latest:
            return
        self._latest = pose.time
        try:
            self._take(pose)
        except CrazychoirError as error:
            self.node.complain(self.topic, error)


class HubPeriodic:
    """Calls ``work(now)`` on a grid of times of the common clock; missed calls are not made up for."""

    def __init__(self, hub: Hub, frequency: float, work: Callable[[float], None]) -> None:
        """Start it."""
        self.frequency = float(frequency)
        """Calls per second (Hz)."""
        self._hub, self._work = hub, work
        self._period = int(1e9 / frequency)
        self._stopped = False
        self.reset()

    def tick(self) -> None:
        """Work, if it is time."""
        late = self._hub.nanoseconds - self._due
        if late >= 0 and not self._stopped:
            self._due += (late // self._period + 1) * self._period
            self._work(self._hub.now)

    def reset(self) -> None:
        """Begin a new grid: the next call is one period from now."""
        self._due = self._hub.nanoseconds + self._period

    def stop(self) -> None:
        """Call no more."""
        self._stopped = True
