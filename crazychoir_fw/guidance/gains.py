"""Gains of the bearing formation by name (docs/reference/crazychoir.md#8.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError, UnknownNameError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FormationGains:
    """Gains per axis, x, y, z; one number stands for all three."""

    k_p: ArrayLike = 0.2
    """Formation: per metre (1/s^2)."""
    k_v: ArrayLike = 1.0
    """Formation: per metre per second (1/s)."""
    k_i: ArrayLike = 0.0
    """Formation: per metre second (1/s^3)."""
    takeoff_k_p: ArrayLike = (0.4, 0.4, 1.25)
    """Take-off and landing of followers: per metre (1/s^2)."""
    takeoff_k_d: ArrayLike = (0.2, 0.2, 0.4)
    """Take-off and landing of followers: per metre per second (1/s)."""
    takeoff_k_i: ArrayLike = 0.0
    """Take-off and landing of followers: per metre second (1/s^3)."""
    takeoff_follows_speed: bool = False
    """Take-off and landing brake against the speed of the reference; otherwise against any, and lag behind."""
    per_neighbor: bool = False
    """Divide what the neighbors add up to by how many they are: one set serves sparse and dense graphs."""
    largest_trim: float = 2.0
    """Most that the integrals ask for, per axis (m/s^2)."""
    largest_acceleration: float = math.inf
    """Most that a follower asks for (m/s^2)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = np.asarray(getattr(self, field.name), dtype=np.float64)
            if value.ndim > 1 or value.size not in (1, 3) or np.isnan(value).any() or (value < 0.0).any():
                raise RangeError(
                    f"gains: {field.name} is {getattr(self, field.name)}, allowed: 0 or more, one or three"
                )
            if "k_" in field.name:
                object.__setattr__(self, field.name, np.broadcast_to(value, 3))


FORMATION_GAINS: dict[str, FormationGains] = {
    "webots": FormationGains(),
    "huge": FormationGains(k_p=0.07, k_v=0.35),
    "vicon": FormationGains(
        k_p=(3.0, 3.0, 10.0),
        k_v=3.0,
        k_i=(0.0, 0.0, 1.0),
        takeoff_k_p=(7.2, 7.2, 30.0),
        takeoff_k_d=(3.6, 3.6, 12.0),
        takeoff_k_i=(0.0, 0.0, 1.0),
    ),
    "mujoco": FormationGains(
        k_p=4.0,
        k_v=5.0,
        k_i=(0.0, 0.0, 0.5),
        takeoff_k_p=(4.0, 4.0, 5.0),
        takeoff_k_d=4.0,
        takeoff_k_i=(2.0, 2.0, 2.5),
        takeoff_follows_speed=True,
        per_neighbor=True,
        largest_acceleration=2.0,
    ),
}
"""``webots``, ``huge`` and ``vicon`` are the original's; ``mujoco`` is tuned for the simulated vehicle."""


def gains_named(gains: str | FormationGains) -> FormationGains:
    """Return gains by name, or as they are.

    Raises:
        UnknownNameError: If there is no such set.
    """
    if isinstance(gains, FormationGains):
        return gains
    if gains not in FORMATION_GAINS:
        raise UnknownNameError(f"gains is {gains!r}, allowed: {', '.join(FORMATION_GAINS)} or FormationGains(...)")
    return FORMATION_GAINS[gains]
