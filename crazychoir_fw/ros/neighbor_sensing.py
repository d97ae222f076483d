"""Neighbors of each drone, found by one node and published on its ``closest_robots`` (docs/reference/crazychoir.md#9).

The message is a `std_msgs/UInt8MultiArray` whose label is the time (ns) of the poses, and whose data are numbers,
positions (m) and velocities (m/s) of the neighbors, nearest first, as `crazychoir_fw.guidance.serialization` writes
arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from std_msgs.msg import UInt8MultiArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control import safety as plain
from crazychoir_fw.control.periodic_timer import PeriodicTimer
from crazychoir_fw.guidance.serialization import dumps, loads
from crazychoir_fw.ros.conversions import labeled_bytes, message_to_bytes, odometry_to_pose
from crazychoir_fw.ros.names import CLOSEST_ROBOTS, ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_triggered import CLOSE

Array = NDArray[np.float64]

_SAME = 1e-7  # [s]: stamps are whole nanoseconds
_MAX_NEAR = 10_000  # robots in a message


# ---------------------------------------------------------------- the message


def closest_to_message(
    time: float, numbers: Sequence[int] | NDArray[np.intp], position: Array, velocity: Array
) -> bytes:
    """Return a message of ``closest_robots`` as bytes.

    Args:
        time: Time of the poses (s).
        numbers: Numbers of the neighbors, nearest first, shape (K,).
        position: Their positions (m, world), shape (K, 3).
        velocity: Their velocities (m/s, world), shape (K, 3).
    """
    who = np.asarray(numbers, np.int64)
    return labeled_bytes(round(time * 1e9), dumps((who, np.asarray(position, float), np.asarray(velocity, float))))


def message_to_closest(message: UInt8MultiArray) -> tuple[float, NDArray[np.int64], Pose]:
    """Return time (s), numbers (K,) and poses (K, 3) of a message of ``closest_robots``.

    Raises:
        CrazychoirError: If the message cannot be decoded.
    """
    label, content = message_to_bytes(message)
    found = loads(content)
    if not (isinstance(found, tuple) and len(found) == 3 and all(isinstance(part, np.ndarray) for part in found)):
        raise RangeError("closest_robots: not numbers, positions and velocities")
    numbers, position, velocity = found
    shape = (len(numbers) if numbers.ndim == 1 else -1, 3)
    is_fine = numbers.dtype.kind == "i" and position.shape == velocity.shape == shape and len(numbers) <= _MAX_NEAR
    if not (is_fine and np.isfinite(position).all() and np.isfinite(velocity).all()):
        raise RangeError(
            f"closest_robots: {len(found[0]) if numbers.ndim else 0} robots with positions {position.shape}, allowed: "
            "(K,) whole numbers, (K, 3) finite positions and velocities"
        )
    return label / 1e9, numbers, Pose(position=np.array(position, float), velocity=np.array(velocity, float))


# ---------------------------------------------------------------- the node


class ClosestRobotGetter(LayerNode):
    """One node for all drones: odometry in, ``closest_robots`` of each drone out."""

    def __init__(
        self,
        sensing_distance: float = 3.0,
        *,
        agents: Sequence[int] | None = None,
        freq: float | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node ``closest_robots_getter``.

        Args:
            sensing_distance: How far drones see (m).
            agents: Numbers of the drones; None asks the parameters ``first_id`` and ``last_id``.
            freq: Looks per second (Hz); None asks the parameter ``freq``.
            parameters: Values of parameters; besides, ``odom_timeout``: age of the odometry (s) at which a
                silent drone counts as at rest; ``forget_after``: age (s) at which it counts as gone; ``least_height``:
                height (m) below which a drone lies on the floor and is no obstacle.
            context: Context of rclpy.
            options: Of `LayerNode`.

        Raises:
            RangeError: If a number is outside its range.
        """
        self._getter = plain.ClosestRobotGetter(sensing_distance)
        super().__init__("closest_robots_getter", parameters=parameters, context=context, swarm_wide=True, **options)
        if agents is None:
            first = self.declare("first_id", 0, "number of the first drone", low=0)
            last = self.declare("last_id", 0, "number of the last drone", low=first)
            agents = range(first, last + 1)
        self.agents = tuple(agents)
        """Numbers of the drones."""
        rate = self.declare("freq", 100.0, "looks per second (Hz)", low=0.001) if freq is None else float(freq)
        self._timeout = self.declare("odom_timeout", 0.5, "age at which a silent drone counts as at rest (s)", low=0.01)
        self._forget = self.declare("forget_after", 5.0, "age at which a silent drone counts as gone (s)", low=0.01)
        self._floor = self.declare("least_height", 0.1, "height below which a drone is no obstacle (m)", float)
        count = len(self.agents)
        self._position, self._velocity = np.full((count, 3), np.nan), np.zeros((count, 3))
        self._stamp, self._came = np.full(count, -np.inf), np.full(count, -np.inf)
        self._published = -np.inf
        nobody: Any = (np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3)))
        self._found = [nobody] * count
        self._schedule = PeriodicTimer(rate)
        self._closest = [self.announce(CLOSEST_ROBOTS, self.topic_of(i, CLOSEST_ROBOTS.name)) for i in self.agents]
        for row, i in enumerate(self.agents):
            self.listen(ODOM, self._pose_taker(row), self.topic_of(i, ODOM.name), fast=True)
        self.when_time_jumps_back(self._begin_anew)
        self.every(rate, self._tick)

    def _pose_taker(self, row: int) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            pose = odometry_to_pose(message)
            now = self.now()
            self._position[row] = pose.position
            self._velocity[row] = 0.0 if pose.velocity is None else pose.velocity
            self._stamp[row] = now if pose.time is None else pose.time
            self._came[row] = max(now, self._stamp[row])
            # simulated poses come all with one stamp: the last one makes the set complete
            if self.is_simulated_time:
                latest = self._stamp[row]
                awaited = latest - self._came < self._timeout
                if latest > self._published and np.all(self._stamp[awaited] >= latest - _SAME):
                    self._look(latest)

        return take

    def _tick(self, now: float) -> None:
        """Look by the clock: in real time, and where no set becomes complete."""
        is_late = np.isfinite(self._stamp).any() and now > self._published + CLOSE * self._schedule.period
        if is_late or not self.is_simulated_time:
            self._look(now)

    def _look(self, now: float) -> None:
        self._published = now
        if self._schedule.is_due(now):
            self._find(now)
        for row, publisher in enumerate(self._closest):
            publisher.publish(closest_to_message(now, *self._found[row]))

    def _find(self, now: float) -> None:
        age = now - self._came
        is_obstacle = (age <= self._forget) & (self._position[:, 2] >= self._floor)
        velocity = np.where((age > self._timeout)[:, None], 0.0, self._velocity)
        table = self._getter.neighbors(self._position)
        numbers = np.array(self.agents)
        for row, others in enumerate(table):
            # a drone on the floor has neighbors, but is no obstacle
            near = others[(others >= 0) & is_obstacle[others]]
            self._found[row] = numbers[near], self._position[near], velocity[near]

    def _begin_anew(self, now: float) -> None:
        del now
        self._position[:], self._stamp[:], self._came[:] = np.nan, -np.inf, -np.inf
        self._published = -np.inf
