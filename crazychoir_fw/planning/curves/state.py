"""Position and its derivatives at one instant."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def _zeros() -> Array:
    return np.zeros(3)


@dataclass(frozen=True)
class State:
    """Where a curve begins or ends."""

    position: Array
    """Position (m), shape (axes,)."""
    velocity: Array = field(default_factory=_zeros)
    """Velocity (m/s), shape (axes,)."""
    acceleration: Array = field(default_factory=_zeros)
    """Acceleration (m/s^2), shape (axes,)."""
    jerk: Array = field(default_factory=_zeros)
    """Jerk (m/s^3), shape (axes,)."""

    def slowed(self, factor: float) -> State:
        """Return the same state on a path that is flown *factor* times as slowly."""
        return State(self.position, self.velocity / factor, self.acceleration / factor**2, self.jerk / factor**3)
