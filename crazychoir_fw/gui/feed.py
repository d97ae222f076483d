"""What browsers receive of a flight: frames, lines of the console, and samples of the variables that they plot."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FRAME_S = 1.0 / 15.0
"""Between two frames for browsers (s, by the clock on the wall)."""

PHASES = ("ground", "flying", "landing", "landed", "failed", "stopped")


@dataclass(frozen=True)
class Frame:
    """What the drones do at an instant."""

    number: int
    time: float
    """Of the flight (s)."""
    rate: float
    """Simulated seconds per second, measured recently."""
    position: Array
    """(N, 3), m, world."""
    orientation: Array
    """(N, 4), xyzw."""
    reference: Array
    """(N, 3), m, world; NaN where there is none."""
    phase: NDArray[np.int8]
    """Numbers of `PHASES`, (N,)."""
    moving: Array
    """Position (m, world) and attitude (xyzw) of the bodies of the room that may move, (M, 7)."""

    def packed(self) -> bytes:
        """Return it as float32: number, time (s), rate, N, then 11 numbers of each drone and 7 of each moving body."""
        rows = np.hstack([self.position, self.orientation, self.reference, self.phase[:, None]])
        head = [self.number % 2**24, self.time, self.rate, len(rows)]
        return np.concatenate([head, rows.ravel(), self.moving.ravel()]).astype("<f4").tobytes()


@dataclass(frozen=True)
class Line:
    """A line of the console."""

    number: int
    time: float
    kind: str
    drone: str
    text: str

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {"number": self.number, "time": round(self.time, 2), "kind": self.kind, "drone": self.drone,
                "text": self.text}  # fmt: skip


class Feed:
    """The frames, console lines and plotted samples of one flight that browsers receive."""

    def __init__(self, names: list[str]) -> None:
        """Begin; `names` are those of the drones."""
        self.names = names
        self.frame: Frame | None = None
        self.lines: deque[Line] = deque(maxlen=2000)
        self.watched: dict[object, tuple[tuple[int, str], ...]] = {}
        """Log variables that browsers plot, by browser: (drone, name)."""
        self.plotted: deque[tuple[float, dict[tuple[int, str], float]]] = deque(maxlen=4000)
        """Time (s) and values of watched variables."""
        self._lines_told = 0

    def say(self, kind: str, text: str, drone: str = "", time: float | None = None) -> None:
        """Write a line to the console."""
        at = (0.0 if self.frame is None else self.frame.time) if time is None else time
        self._lines_told += 1
        self.lines.append(Line(self._lines_told, at, kind, drone, text))

    def lines_since(self, number: int) -> list[dict[str, Any]]:
        """Return the lines of the console after one."""
        return [line.as_dict() for line in list(self.lines) if line.number > number]
