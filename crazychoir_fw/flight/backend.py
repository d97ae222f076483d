"""What layers fly: N drones with poses, commands and a clock, wherever they are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.recording.log_stream import LogStream

Indices = Sequence[int] | NDArray[np.intp]
"""Numbers of drones, from 0, in the order of `Backend.names`."""

_BEHIND_S = 0.1  # a flight later than this does not try to catch up

KINDS = ("fpqr", "frpy", "vel")
"""Commands by Twist: thrust and body rates; thrust and roll, pitch, yaw; velocity and yaw rate."""


class Backend(Protocol):
    """Where drones live. Simulated ones have no clock but their own."""

    names: list[str]
    """Names of the drones."""
    masses: NDArray[np.float64]
    """What they weigh, as far as is known (kg), shape (N,)."""
    is_real_time: bool
    """Whether time goes on by itself."""

    @property
    def time(self) -> float:
        """Time (s), by the clock that poses have as well."""

    def poses(self) -> Pose:
        """Return where all drones are, arrays of shape (N, ...); NaN for a drone whose pose is stale."""

    def pose_of(self, index: int) -> Pose:
        """Return where one drone is, arrays of shape (3,)."""

    def true_positions(self) -> NDArray[np.float64]:
        """Return the true positions, or the measured ones without a simulation (m, world), shape (N, 3)."""

    def unlock(self, indices: Indices) -> list[int]:
        """Let motors run; returns the drones whose motors may not."""

    def send(self, indices: Indices, twist: Twist, kind: str) -> None:
        """Give commands of a kind ``fpqr``, ``frpy`` or ``vel``: a Twist with arrays of shape (len(indices), 3)."""

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """Let the planner on board fly to a point within its time."""

    def land(self, index: int, floor: float, seconds: float) -> None:
        """Have a drone land where it is without any layer: down to the height of a floor (m) within a time (s)."""

    def advance(self, seconds: float) -> None:
        """Let time go on."""

    def stop(self, indices: Indices) -> None:
        """Motors off."""

    def failures(self) -> dict[int, str]:
        """Return the drones that cannot fly any more, with a sentence each that says why."""

    def record(self, extra: dict[str, NDArray[np.float64]]) -> None:
        """Take a sample of everything for the log; `extra` are signals of the layers, shape (N,) each, to be copied."""

    def write_to(self, stream: LogStream, metadata: dict[str, Any]) -> None:
        """Have `flush` move what is recorded to a stream; `metadata` is for a log that is cut off."""

    def flush(self) -> None:
        """Move what was recorded since the last call to the stream, if there is one."""

    def log(self, metadata: dict[str, Any]) -> FlightLog:
        """Return what was recorded."""

    def close(self) -> None:
        """Let go of the drones."""


def one_of(poses: Pose, index: int) -> Pose:
    """Return the pose of one drone out of those of many."""
    return Pose(
        position=None if poses.position is None else poses.position[index],
        orientation=None if poses.orientation is None else poses.orientation[index],
        velocity=None if poses.velocity is None else poses.velocity[index],
        angular=None if poses.angular is None else poses.angular[index],
        time=poses.time,
    )


def some_of(poses: Pose, indices: Indices) -> Pose:
    """Return the poses of some drones out of those of many."""
    return one_of(poses, indices)  # type: ignore[arg-type]


class WallPace:
    """Rounds of drones whose time goes on by itself: waits until the next one is due."""

    def __init__(self, clock: Callable[[], float], sleep: Callable[[float], None]) -> None:
        """Take a clock (s), and what lets time go on (s)."""
        self._clock, self._sleep = clock, sleep
        self._due = clock()
        self.worst_lag_s = 0.0
        """How late a round was at worst (s)."""

    def begin_anew(self) -> None:
        """Count from now, after something else has taken its time."""
        self._due = self._clock()

    def wait(self, seconds: float) -> None:
        """Wait until so long after the round before was due (s)."""
        self._due += seconds
        wait = self._due - self._clock()
        self.worst_lag_s = max(self.worst_lag_s, -wait)
        if wait > 0.0:
            self._sleep(wait)
        elif wait < -_BEHIND_S:
            self._due = self._clock()
