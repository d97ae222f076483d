"""`PositionTaskExecutor`: flies to the point of a task, and says when it is there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError

Array = NDArray[np.float64]

_SHORTEST_S = 2.0  # of a flight, however near the point is
_LATE = 3.0  # times the duration, and this many seconds more, after which a flight will not arrive
_LATE_S = 5.0


class PositionTaskExecutor:
    """One drone's way to one point after the other, at a height of its own.

    Drones that fly at different heights cross each other's ways. A repeated command to the same goal changes nothing.
    """

    def __init__(
        self, height: float, *, tolerance: float = 0.05, speed: float = 0.5, duration: float | None = None
    ) -> None:
        """Prepare.

        Args:
            height: At which it flies (m).
            tolerance: Level distance at which it has arrived (m).
            speed: Mean speed of a flight (m/s).
            duration: How long every flight lasts (s), instead of the speed; the original's lasted 20 s.

        Raises:
            RangeError: If a number is not above zero.
        """
        for name, value in (("height", height), ("tolerance", tolerance), ("speed", speed), ("duration", duration)):
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise RangeError(f"executor: {name} is {value}, allowed: above 0")
        self.height = height
        self.tolerance = tolerance
        self.speed = speed
        self.duration = duration
        self.goal: Array | None = None
        """Where it is going (m, world), shape (3,); None: nowhere."""
        self._arrives = 0.0

    def go(self, point: ArrayLike, position: Array, now: float) -> tuple[Array, float] | None:
        """Go to a point; returns where (m) and for how long (s), or None if it is on its way there.

        Args:
            point: The point (m, world), shape (2,) or (3,); with a third number it is not at the height of the drone.
            position: Where the drone is (m, world), shape (3,).
            now: Time (s).
        """
        goal = np.array([*np.asarray(point, float), self.height][:3])
        if self.goal is not None and np.array_equal(goal, self.goal):
            return None
        distance = float(np.linalg.norm(goal - position))
        duration = max(_SHORTEST_S, distance / self.speed) if self.duration is None else self.duration
        self.goal = goal
        self._arrives = now + duration
        self._gives_up = now + _LATE * duration + _LATE_S
        return goal, duration

    def stay(self, position: Array) -> tuple[Array, float] | None:
        """Go nowhere any more; returns where to wait, or None if it was going nowhere."""
        if self.goal is None:
            return None
        self.goal = None
        return np.array([position[0], position[1], self.height]), _SHORTEST_S

    def has_arrived(self, position: Array) -> bool:
        """Return whether it is where it was going."""
        if self.goal is None:
            return False
        return math.hypot(position[0] - self.goal[0], position[1] - self.goal[1]) < self.tolerance

    def is_late(self, now: float) -> bool:
        """Return whether it should have been there long ago."""
        return self.goal is not None and now > self._gives_up
