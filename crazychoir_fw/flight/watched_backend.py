"""`WatchedBackend`: bodies that motion capture tracks and this process does not command, in wall-clock time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.flight.backend import Indices, WallPace, one_of
from crazychoir_fw.flight.plain_recorder import PlainRecorder
from crazychoir_fw.mocap import Estimator
from crazychoir_fw.mocap.sources import PoseSource

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.recording.log_stream import LogStream

Array = NDArray[np.float64]


class WatchedBackend:
    """Poses come from motion capture, velocities from a filter. Commands are dropped."""

    is_real_time = True

    def __init__(
        self,
        bodies: Mapping[str, str],
        source: PoseSource,
        *,
        masses: ArrayLike = 0.029,
        stale_s: float = 0.5,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Watch.

        Args:
            bodies: What the source calls each drone, by the name of the drone.
            source: Where poses come from; its clock is the same.
            masses: What they weigh (kg), a number or shape (N,).
            stale_s: Age at which a pose counts as unknown (s).
            clock: Time (s).
            sleep: Lets time go on (s).
        """
        self.names = list(bodies)
        self.masses = np.broadcast_to(np.asarray(masses, float), (len(bodies),)).copy()
        self.pace = WallPace(clock, sleep)
        self._bodies = list(bodies.values())
        self._source = source
        self._stale_s = stale_s
        self._clock, self._start = clock, clock()
        self._filters = [Estimator() for _ in bodies]
        self._newest: list[Pose | None] = [None] * len(bodies)
        self._recorder = PlainRecorder(self.names)

    @property
    def time(self) -> float:
        """See `Backend`."""
        return self._clock() - self._start

    def poses(self) -> Pose:
        """See `Backend`."""
        count, now = len(self.names), self._clock()
        seen = self._source.latest()
        position, velocity, angular = np.full((count, 3), np.nan), np.zeros((count, 3)), np.zeros((count, 3))
        orientation = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
        for i, body in enumerate(self._bodies):
            sample = seen.get(body)
            if sample is not None and sample is not self._newest[i]:
                self._newest[i] = sample
                self._filters[i].update(sample)
            estimate = self._filters[i].estimate
            if estimate.time is not None and now - estimate.time < self._stale_s:
                position[i], orientation[i] = estimate.position, estimate.orientation
                velocity[i], angular[i] = estimate.velocity, estimate.angular
        return Pose(position, orientation, velocity, angular, now - self._start)

    def pose_of(self, index: int) -> Pose:
        """See `Backend`."""
        return one_of(self.poses(), index)

    def true_positions(self) -> Array:
        """See `Backend`: what is seen."""
        return self.poses().position

    def unlock(self, indices: Indices) -> list[int]:
        """See `Backend`: no motors are locked, since these bodies take no commands."""
        return []

    def send(self, indices: Indices, twist: Twist, kind: str) -> None:
        """See `Backend`: dropped, since these bodies take no commands."""

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """See `Backend`: dropped, since these bodies take no commands."""

    def land(self, index: int, floor: float, seconds: float) -> None:
        """See `Backend`: dropped, since these bodies take no commands."""

    def stop(self, indices: Indices) -> None:
        """See `Backend`: dropped, since these bodies take no commands."""

    def advance(self, seconds: float) -> None:
        """See `Backend`."""
        self.pace.wait(seconds)

    def failures(self) -> dict[int, str]:
        """See `Backend`: a body that takes no commands cannot fail."""
        return {}

    def record(self, extra: dict[str, Array]) -> None:
        """See `Backend`."""
        self._recorder.sample(self.time, self.poses(), None, extra)

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
        self._source.close()
