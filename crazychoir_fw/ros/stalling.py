"""A clock for waiting that also goes on where simulated time stands still."""

from __future__ import annotations

import time
from collections.abc import Callable


class StallingClock:
    """The clock of a node, plus the time on the wall for which it has been waited for in vain.

    A simulation in lock step waits for a node that waits for a neighbor that is gone: by simulated time that would last
    for ever. Waits that are shorter than the patience do not count, so that a slow machine changes nothing.
    """

    def __init__(self, clock: Callable[[], float], patience: float, wall: Callable[[], float] = time.monotonic) -> None:
        """Go with a clock.

        Args:
            clock: Returns the time of the node (s).
            patience: How long a wait may last that does not count (s, wall).
            wall: Returns the time on the wall (s).
        """
        self._clock = clock
        self._patience = patience
        self._wall = wall
        self._waited = 0.0  # [s], in vain, so far
        self._seen = clock()
        self._since = wall()

    @property
    def has_waited(self) -> bool:
        """Whether anything was ever waited for in vain."""
        return self._waited > 0.0

    def now(self) -> float:
        """Return the time (s)."""
        return self._clock() + self._waited

    def begin(self) -> float:
        """Begin to wait; returns the time (s)."""
        self._seen, self._since = self._clock(), self._wall()
        return self._seen + self._waited

    def look(self) -> None:
        """See whether the clock still goes; to be called now and then while waiting."""
        seen, wall = self._clock(), self._wall()
        if seen != self._seen:
            self._seen, self._since = seen, wall
        elif wall - self._since >= self._patience:
            self._waited += wall - self._since
            self._since = wall
