"""Points that a trajectory shall go through."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


def _zeros() -> NDArray[np.float64]:
    return np.zeros(3)


@dataclass(frozen=True)
class TrajectoryPoint:
    """One point of the topic ``traj_params``: a list of one is a go-to, of many a drawn trajectory."""

    time_s: float
    """Time from the begin (s)."""
    position: NDArray[np.float64]
    """Position (m, world), shape (3,)."""
    velocity: NDArray[np.float64] = field(default_factory=_zeros)
    """Velocity there (m/s, world), shape (3,)."""
    acceleration: NDArray[np.float64] = field(default_factory=_zeros)
    """Acceleration there (m/s^2, world), shape (3,)."""
    jerk: NDArray[np.float64] = field(default_factory=_zeros)
    """Jerk there (m/s^3, world), shape (3,)."""
