"""Rounds that keep pace with a clock, for drones whose time goes on by itself."""

from __future__ import annotations

from collections.abc import Callable

_BEHIND_S = 0.1  # who is later than this does not try to catch up


class WallPace:
    """Waits until the next round is due."""

    def __init__(self, clock: Callable[[], float], sleep: Callable[[float], None]) -> None:
        """Take a clock (s), and what lets time go on (s)."""
        self._clock, self._sleep = clock, sleep
        self._due = clock()
        self.worst_lag_s = 0.0
        """How late a round was at worst (s)."""

    def begin_anew(self) -> None:
        """Count from now, after something else has taken its time."""
        self._due = self._clock()

    def wait(self, seconds: float) -> None:
        """Wait until so long after the round before was due (s)."""
        self._due += seconds
        wait = self._due - self._clock()
        self.worst_lag_s = max(self.worst_lag_s, -wait)
        if wait > 0.0:
            self._sleep(wait)
        elif wait < -_BEHIND_S:
            self._due = self._clock()
