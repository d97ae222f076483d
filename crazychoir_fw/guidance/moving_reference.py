"""A reference that integrates the velocity from guidance to a place, so that any controller can follow it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference

Array = NDArray[np.float64]

LONGEST_STEP = 0.1
"""Max time that one step covers (s), so that a reference does not leap after a pause between steps."""

_LIMITS = {"max_speed": "m/s", "leash": "m"}


class MovingReference:
    """Position and velocity of a reference.

    A velocity alone is followed with an error that adds up: nothing takes a drone back that wind or a weak battery has
    carried away. So velocities are integrated, and controllers are handed both, the place and the velocity. The place
    never leaves the drone by more than a leash, so that a drone which is held does not dart off when it comes free.
    """

    def __init__(self, max_speed: float, leash: float, lowest: float) -> None:
        """Choose limits.

        Args:
            max_speed: Largest speed (m/s); what is faster keeps its direction.
            leash: Largest distance from the drone (m).
            lowest: Least height in flight (m); a reference that is lower already only rises.

        Raises:
            RangeError: If a limit is outside its range.
        """
        for (name, unit), value in zip(_LIMITS.items(), (max_speed, leash), strict=True):
            if not value > 0.0:
                raise RangeError(f"{name} is {value}, allowed: above 0 {unit}")
        if not math.isfinite(lowest):
            raise RangeError(f"lowest is {lowest}, allowed: a height (m)")
        self.max_speed = float(max_speed)
        self.leash = float(leash)
        self.lowest = float(lowest)
        self.position: Array | None = None
        """Where it is (m, world), shape (3,); None before it began."""

    def begin(self, position: Array) -> None:
        """Begin at a place (m, world), shape (3,)."""
        self.position = np.array(position, dtype=np.float64)

    def move(self, velocity: Array, drone: Array, period: float) -> Reference:
        """Move on, and return the reference.

        Args:
            velocity: Asked for (m/s, world), shape (3,).
            drone: Where the drone is (m, world), shape (3,).
            period: Since the step before (s).
        """
        if self.position is None:
            self.begin(drone)
        position: Array = self.position  # type: ignore[assignment]
        velocity = shortened(np.asarray(velocity, dtype=np.float64), self.max_speed)
        floor = min(position[2], self.lowest)
        after = position + min(period, LONGEST_STEP) * velocity
        after = drone + shortened(after - drone, self.leash)
        if after[2] < floor:
            after[2] = floor
            velocity = velocity * (1.0, 1.0, 0.0)
        self.position = after
        return Reference(position=after.copy(), velocity=velocity, acceleration=np.zeros(3))

    def rise(self, height: float, speed: float, period: float) -> Reference:
        """Move straight up or down to a height (m) with a speed (m/s), and return the reference.

        Raises:
            RangeError: If it has not begun.
        """
        if self.position is None:
            raise RangeError("the reference has not begun")
        left = height - self.position[2]
        step = math.copysign(min(speed * min(period, LONGEST_STEP), abs(left)), left)
        self.position = self.position + np.array([0.0, 0.0, step])
        moves = abs(left) > abs(step)
        velocity = np.array([0.0, 0.0, math.copysign(speed, left) if moves else 0.0])
        return Reference(position=self.position.copy(), velocity=velocity, acceleration=np.zeros(3))


def shortened(vector: Array, largest: float) -> Array:
    """Return a vector, shape (3,), that is no longer than allowed, in the same direction."""
    if largest == math.inf:
        return vector
    size = math.sqrt(vector @ vector)
    return vector if size <= largest else vector * (largest / size)
