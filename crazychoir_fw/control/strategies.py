"""What a position law and an attitude law are: override `control`.

A law takes one drone, arrays of shape (3,), or a group of equal drones at once, (N, 3).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control.periodic_timer import checked_frequency

Array = NDArray[np.float64]


class PositionCtrlStrategy(ABC):
    """Turns pose and reference into thrust and attitude."""

    follows_position = True
    """Whether it pulls the drone to the position of a reference; otherwise `HierarchicalController` asks it for
    accelerations that do, where the drone is to stay in place."""

    desired_rates: Array | None = None
    """Body rates (rad/s) at which the attitude that was returned last turns, in its own frame, shape (..., 3); None
    where they are not known. `HierarchicalController` hands them to the attitude law."""

    filtered: ClassVar[type[PositionCtrlStrategy]]
    """The law that takes the place of this very class, not of its subclasses, behind a safety filter."""

    def __init__(self, update_frequency: float = 100.0) -> None:
        """Make a law that is evaluated at a frequency (Hz)."""
        self.update_frequency = checked_frequency(type(self).__name__, "update_frequency", update_frequency)

    @classmethod
    def with_filter(cls) -> type[PositionCtrlStrategy]:
        """Return the law that takes a `safety_filter` and those nearby: `filtered`, or itself."""
        return vars(cls).get("filtered", cls)

    @abstractmethod
    def control(self, current_pose: Pose, desired_reference: Reference) -> tuple[Array, Array]:
        """Return thrust (N), shape (...), and attitude, matrices from body to world, shape (..., 3, 3)."""

    def reset(self) -> None:  # noqa: B027 few laws learn anything
        """Forget what was learned in flight; called when nothing is followed any more."""


class AttitudeCtrlStrategy(ABC):
    """Turns pose and attitude into body rates."""

    desired_rates: Array | None = None
    """Body rates (rad/s) at which the desired attitude turns, in its own frame, shape (..., 3); None where they are
    not known. `HierarchicalController` sets them before `control`."""

    def __init__(self, update_frequency: float = 100.0) -> None:
        """Make a law that is evaluated at a frequency (Hz)."""
        self.update_frequency = checked_frequency(type(self).__name__, "update_frequency", update_frequency)

    @abstractmethod
    def control(self, current_pose: Pose, desired_attitude: Array, desired_reference: Reference) -> Array:
        """Return body rates p, q, r (rad/s), shape (..., 3)."""

    def reset(self) -> None:  # noqa: B027 few laws learn anything
        """Forget what was learned in flight; called when nothing is followed any more."""


PositionControl = PositionCtrlStrategy
"""The paper's name."""
AttitudeControl = AttitudeCtrlStrategy
"""The paper's name."""
