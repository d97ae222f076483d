"""What is known of all flights at one instant, as arrays of N rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


@dataclass
class Motion:
    """Where drones are and how they move: as they believe, or in truth."""

    position: Floats
    """(m, world), shape (N, 3)."""
    velocity: Floats
    """(m/s, world), shape (N, 3)."""
    rotation: Floats
    """Body to world, row by row, shape (N, 9)."""
    rates: Floats
    """Angular velocity (rad/s, body), shape (N, 3)."""


@dataclass
class Reference:
    """What drones are to follow at one instant."""

    position: Floats
    """(m, world), shape (N, 3)."""
    velocity: Floats
    """(m/s, world), shape (N, 3)."""
    acceleration: Floats
    """(m/s^2, world), shape (N, 3)."""


@dataclass
class Reading:
    """Everything that observations, rewards and terminations are made of."""

    estimate: Motion
    """What the drones believe: the filter's estimate, and the filtered gyroscope."""
    truth: Motion
    """What the simulator knows."""
    specific_force: Floats
    """Of the filtered accelerometer (m/s^2, body; +9.81 along z at rest), shape (N, 3)."""
    ranges: Floats | None
    """Of the multi-ranger deck: front, back, up, left, right (m, at most 4), shape (N, 5); None without the deck."""
    battery_voltage: Floats
    """(V), shape (N,)."""
    is_out: NDArray[np.bool_]
    """Whether the core or the supervisor has stopped the drone, shape (N,)."""
    is_touching: NDArray[np.bool_]
    """Whether the drone touched anything in the latest step, shape (N,)."""
    reference: Reference
    action: Floats
    """The latest action, shape (N, A)."""
    previous_action: Floats
    """The one before, shape (N, A)."""
    seconds: Floats
    """Time since the begin of the episode (s), shape (N,)."""


def rotation_of(quat_wxyz: NDArray[np.floating]) -> Floats:
    """Return rotation matrices, row by row, shape (N, 9), of unit quaternions (w, x, y, z), shape (N, 4).

    In float32 and in the order of operations of the exported C (`policy/c_source.py`).
    """
    w, x, y, z = np.asarray(quat_wxyz, np.float32).T
    one, two = np.float32(1.0), np.float32(2.0)
    rows = (
        *(one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)),
        *(two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)),
        *(two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)),
    )
    return np.stack(rows, axis=1)
