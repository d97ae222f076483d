"""The box that drones are kept in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError

_COMMANDS = ("clamp", "refuse")
_BREACHES = ("land", "stop", "report")
_BACK = 0.3  # m/s


@dataclass(frozen=True)
class SafetyArea:
    """A box in the world, what becomes of commands that lead out of it, and of drones that are outside.

    Raises:
        RangeError: If it is no box, or a word is unknown.
    """

    low: Sequence[float]
    """Lowest corner (m, world), shape (3,)."""
    high: Sequence[float]
    """Highest corner (m, world), shape (3,)."""
    commands: str = "clamp"
    """``clamp``: goals and velocities are bent to stay inside; ``refuse``: they raise a RangeError."""
    breach: str = "land"
    """What is done with a drone that flies outside of the box and its margin: ``land``, ``stop`` (motors off), or only
    ``report`` (`on_event`)."""
    margin: float = 0.2
    """How far outside of the box a drone may be before that (m)."""
    horizon_s: float = 0.5
    """A velocity may lead at most to the border in this time (s), so that drones slow down in front of it."""

    def __post_init__(self) -> None:
        try:
            box = np.array([self.low, self.high], float).reshape(2, 3)
        except (TypeError, ValueError):
            box = np.full((2, 3), np.nan)
        if not (np.all(np.isfinite(box)) and np.all(box[0] < box[1])):
            raise RangeError(
                f"safety area is {self.low!r} to {self.high!r}, allowed: lowest and highest corner, three numbers each"
            )
        if self.commands not in _COMMANDS:
            raise RangeError(f"safety area: commands is {self.commands!r}, allowed: {', '.join(_COMMANDS)}")
        if self.breach not in _BREACHES:
            raise RangeError(f"safety area: breach is {self.breach!r}, allowed: {', '.join(_BREACHES)}")
        if not (np.isfinite(self.margin) and self.margin >= 0.0):
            raise RangeError(f"safety area: margin is {self.margin!r}, allowed: a number from 0 (m)")
        if not (np.isfinite(self.horizon_s) and self.horizon_s > 0.0):
            raise RangeError(f"safety area: horizon_s is {self.horizon_s!r}, allowed: a number above 0 (s)")
        object.__setattr__(self, "_box", box)

    def contains(self, position: Sequence[float], margin: float = 0.0) -> bool:
        """Return whether a point (m, world) is inside, or at most a margin (m) outside."""
        low, high = self._box  # type: ignore[attr-defined]
        point = np.asarray(position, float)
        return bool(np.all(point >= low - margin) and np.all(point <= high + margin))

    def goal(self, who: str, position: Sequence[float]) -> tuple[float, float, float]:
        """Return a goal that is inside (m, world), shape (3,).

        Raises:
            RangeError: If it is outside and commands are refused.
        """
        low, high = self._box  # type: ignore[attr-defined]
        if self.commands == "refuse" and not self.contains(position):
            raise RangeError(f"{who}: {_shown(position)} is outside of the safety area {self}")
        x, y, z = np.clip(np.asarray(position, float), low, high).tolist()
        return x, y, z

    def velocity(self, position: NDArray[np.float64], velocity: Sequence[float]) -> tuple[float, float, float]:
        """Return a velocity (m/s, world), shape (3,), that does not reach the border within the horizon.

        Outside it leads back slowly.
        """
        low, high = self._box  # type: ignore[attr-defined]
        slowest = np.minimum((low - position) / self.horizon_s, _BACK)
        fastest = np.maximum((high - position) / self.horizon_s, -_BACK)
        vx, vy, vz = np.clip(np.asarray(velocity, float), slowest, fastest).tolist()
        return vx, vy, vz

    def leads_out(self, position: NDArray[np.float64], velocity: Sequence[float]) -> bool:
        """Return whether a velocity (m/s, world) leads out within the horizon, or farther out."""
        low, high = self._box  # type: ignore[attr-defined]
        ahead = position + self.horizon_s * np.asarray(velocity, float)
        return bool(np.any(ahead < np.minimum(low, position)) or np.any(ahead > np.maximum(high, position)))

    def __str__(self) -> str:
        low, high = self._box  # type: ignore[attr-defined]
        return f"{_shown(low)} to {_shown(high)} m"


def _shown(point: Sequence[float]) -> str:
    return "(" + ", ".join(f"{float(value):g}" for value in point) + ")"
