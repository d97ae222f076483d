"""How often and how soon a lost drone is called again."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from crazychoir_fw.common.errors import RangeError


@dataclass(frozen=True)
class ReconnectPolicy:
    """Attempts after a loss, with growing waits before each.

    Raises:
        RangeError: If a number is out of its range.
    """

    attempts: int = 10
    """How many; 0 gives the drone up at once."""
    first_wait_s: float = 0.5
    """Wait before the first attempt (s)."""
    factor: float = 2.0
    """What each wait is longer than the one before."""
    longest_wait_s: float = 5.0
    """No wait is longer (s)."""
    resumes: bool = False
    """Whether commands are taken again as soon as the link is back. Without it a drone that was lost waits for
    `resume` or `takeoff`: it may lie on the floor, next to the person who picks it up."""

    def __post_init__(self) -> None:
        for name in ("attempts", "first_wait_s", "longest_wait_s"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RangeError(f"{name} is {getattr(self, name)!r}, allowed: a number from 0")
        if not (math.isfinite(self.factor) and self.factor >= 1.0):
            raise RangeError(f"factor is {self.factor!r}, allowed: a number from 1")

    def waits(self) -> Iterator[float]:
        """Yield the wait before each attempt (s)."""
        wait = self.first_wait_s
        for _ in range(self.attempts):
            yield min(wait, self.longest_wait_s)
            wait *= self.factor
