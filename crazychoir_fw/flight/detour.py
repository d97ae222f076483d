"""A way for a drone that follows its guidance alone: until the next button it flies there and hovers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance.climb import toward

Array = NDArray[np.float64]

# of double integrators: damped by 0.8, and slower than the attitude follows
_P = 6.0  # [1/s^2]
_D = 4.0  # [1/s]


@dataclass
class Detour:
    """A straight way from rest to rest, by a polynomial of degree 5 in time."""

    start: Array
    """Where it begins (m, world), shape (3,)."""
    goal: Array
    """Where it ends (m, world), shape (3,)."""
    began: float
    """When (s)."""
    duration: float
    """How long it takes (s), above 0."""

    def reference(self, now: float) -> Reference:
        """Return where to be at a time (s); after the end, at the goal."""
        s = float(np.clip((now - self.began) / self.duration, 0.0, 1.0))
        way = self.goal - self.start
        return Reference(
            position=self.start + way * (s**3 * (10.0 - 15.0 * s + 6.0 * s * s)),
            velocity=way * (30.0 * s * s * (1.0 - s) ** 2 / self.duration),
            acceleration=way * (60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / self.duration**2),
        )

    def acceleration(self, pose: Pose, now: float) -> Array:
        """Return the acceleration (m/s^2, world), shape (3,), of a drone that keeps to the way."""
        wanted = self.reference(now)
        assert wanted.position is not None and wanted.velocity is not None and wanted.acceleration is not None
        return wanted.acceleration + toward(pose, wanted.position, wanted.velocity, _P, _D)
