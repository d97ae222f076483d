"""`IntegratorBackend`: the light alternative to the simulated vehicle, all drones in one batch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.flight.backend import Indices, one_of
from crazychoir_fw.flight.plain_recorder import PlainRecorder
from crazychoir_fw.onboard.thrust import platform_max_thrust
from crazychoir_fw.simulation.integrator import CrazyflieIntegrator, RandomForce
from crazychoir_fw.simulation.integrator.loops import AttitudeLoop, GoToLoop, VelocityLoop

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.recording.log_stream import LogStream

Array = NDArray[np.float64]

_STEPS_PER_SECOND = 100  # the rate of the original; by Runge-Kutta it is exact enough for any of our loops


class _Commands:
    """The latest command of each drone: drones of one integrator may be flown in different ways."""

    def __init__(self, count: int, weight: Array) -> None:
        self.fixed = np.zeros((count, 4))  # thrust and rates of those that are flown so
        self.fixed[:, 0] = weight
        self.is_attitude = np.zeros(count, bool)
        self.is_velocity = np.zeros(count, bool)
        self.rpy, self.velocity, self.yaw_rate = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
        self.goals: dict[int, GoToLoop] = {}

    def forget(self, indices: Indices) -> None:
        self.is_attitude[indices] = self.is_velocity[indices] = False
        for i in indices:
            self.goals.pop(int(i), None)

    def __call__(self, time: float, state: Array, mass: Array, gravity: float) -> Array:
        command = self.fixed.copy()
        for chosen, loop in (
            (self.is_attitude, lambda at: AttitudeLoop(self.fixed[at, 0], self.rpy[at])),
            (self.is_velocity, lambda at: VelocityLoop(self.velocity[at], self.yaw_rate[at])),
        ):
            if chosen.any():
                command[chosen] = loop(chosen)(time, state[chosen], mass[chosen], gravity)
        for i, goal in self.goals.items():
            command[i] = goal(time, state[i], mass[i], gravity)
        return command


class _Fleet(CrazyflieIntegrator):
    """An integrator whose drones follow commands of different kinds."""

    def fly(self, commands: _Commands) -> None:
        self._loop = commands


class IntegratorBackend(Stateful):
    """Point masses that follow commands without delay. A drone that starts above the floor waits there."""

    is_real_time = False
    unkept = ("_recorder",)

    def __init__(
        self,
        names: Sequence[str],
        positions: ArrayLike,
        *,
        yaw: ArrayLike = 0.0,
        mass: ArrayLike = 0.029,
        platform: str = "cf2",
        drag: ArrayLike | str | None = None,
        disturbance: RandomForce | None = None,
    ) -> None:
        """Place the drones.

        Args:
            names: Names of the drones.
            positions: Where they start (m, world), shape (N, 3).
            yaw: Headings at the start (rad), a number or shape (N,).
            mass: Masses (kg), a number or shape (N,).
            platform: Airframe, whose full thrust bounds that of the commands.
            drag: As of `CrazyflieIntegrator`.
            disturbance: Random force.

        Raises:
            RangeError: If a number is outside its range.
        """
        start = np.array(positions, float)
        if start.shape != (len(names), 3):
            raise RangeError(f"positions have shape {start.shape}, allowed: {(len(names), 3)}")
        self.names = list(names)
        angles = np.zeros((len(names), 3))
        angles[:, 2] = yaw
        self.integrator = _Fleet(
            _STEPS_PER_SECOND,
            init_pos=start,
            init_rpy=angles,
            mass=mass,
            platform=platform,
            drag=drag,
            disturbance=disturbance,
            floor=0.0,
        )
        self.masses = self.integrator.mass
        self._max_thrust = platform_max_thrust(platform)
        weight = np.where(start[:, 2] > 0.0, self.masses * self.integrator.gravity, 0.0)
        self._commands = _Commands(len(names), weight)
        self.integrator.fly(self._commands)
        self._due = 0.0  # steps that rounds have left over
        self._recorder = PlainRecorder(names)
        self.read_poses: Callable[[], Pose] = self._truth
        """Returns the poses that the layers receive."""

    @property
    def time(self) -> float:
        """See `Backend`."""
        return self.integrator.time

    def poses(self) -> Pose:
        """See `Backend`."""
        return self.read_poses()

    def _truth(self) -> Pose:
        seen = self.integrator.odometry
        return Pose(seen.position, seen.quat_xyzw, seen.velocity, seen.rates, seen.time)

    def pose_of(self, index: int) -> Pose:
        """See `Backend`."""
        return one_of(self.poses(), index)

    def true_poses(self) -> Pose:
        """Return where all drones are and how they move."""
        return self._truth()

    def true_positions(self) -> Array:
        """See `Backend`."""
        return self.integrator.state[:, 0:3].copy()

    def unlock(self, indices: Indices) -> list[int]:
        """See `Backend`."""
        return []

    def send(self, indices: Indices, twist: Twist, kind: str) -> None:
        """See `Backend`.

        Raises:
            RangeError: If a number is not finite.
        """
        linear, angular = np.asarray(twist.linear, float), np.asarray(twist.angular, float)
        if not (np.isfinite(linear).all() and np.isfinite(angular).all()):
            raise RangeError(f"command is linear {linear}, angular {angular}, allowed: finite numbers")
        commands = self._commands
        commands.forget(indices)
        if kind == "vel":
            commands.velocity[indices], commands.yaw_rate[indices] = linear, angular[:, 2]
            commands.is_velocity[indices] = True
            return
        commands.fixed[indices, 0] = np.clip(linear[:, 2], 0.0, self._max_thrust)
        if kind == "fpqr":
            commands.fixed[indices, 1:4] = angular
        else:
            commands.rpy[indices] = angular
            commands.is_attitude[indices] = True

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """See `Backend`."""
        state = self.integrator.state[index]
        self._commands.forget([index])
        self._commands.goals[index] = GoToLoop(
            self.time,
            float(point.time_s),
            state[0:3].copy(),
            state[6:9].copy(),
            state[5].copy(),
            np.asarray(point.position, float),
            np.zeros(()),
        )

    def land(self, index: int, floor: float, seconds: float) -> None:
        """See `Backend`."""
        x, y, _ = self.integrator.state[index, 0:3]
        self.go_to(index, TrajectoryPoint(seconds, np.array([x, y, floor])))

    def advance(self, seconds: float) -> None:
        """See `Backend`."""
        self._due += seconds * _STEPS_PER_SECOND
        steps = round(self._due)
        self._due -= steps
        self.integrator.step(steps)

    def stop(self, indices: Indices) -> None:
        """See `Backend`."""
        self._commands.forget(indices)
        self._commands.fixed[indices] = 0.0

    def failures(self) -> dict[int, str]:
        """See `Backend`."""
        return {}

    def record(self, extra: dict[str, Array]) -> None:
        """See `Backend`."""
        self._recorder.sample(self.time, self.poses(), self._truth(), extra)

    def write_to(self, stream: LogStream, metadata: dict[str, Any]) -> None:
        """See `Backend`."""
        self._recorder.write_to(stream, metadata)

    def flush(self) -> None:
        """See `Backend`."""
        self._recorder.flush()

    def log(self, metadata: dict[str, Any]) -> FlightLog:
        """See `Backend`."""
        return self._recorder.finish(metadata)

    def close(self) -> None:
        """See `Backend`."""
