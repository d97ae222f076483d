"""The time that a server goes by: that of the wall or that of its world, whichever drives, and never backwards."""

from __future__ import annotations

from collections.abc import Callable


class Clock:
    """Seconds since some start. Any thread may ask; one thread at a time tells it whom to follow."""

    def __init__(self, read: Callable[[], float], rate: float = 1.0) -> None:
        """Follow a source from zero on, see `follow`."""
        self._latest = 0.0
        self._source = (read, rate, read(), 0.0)

    def follow(self, read: Callable[[], float], rate: float = 1.0) -> None:
        """Go on from the present reading with another source.

        Args:
            read: Returns the time of the source (s); where it begins does not matter.
            rate: Seconds of this clock per second of the source.
        """
        now = self()
        self._source = (read, rate, read(), now)

    def __call__(self) -> float:
        """Return the time (s)."""
        read, rate, zero, base = self._source
        # a source that was put back, as a world is by a snapshot, makes this clock wait and not go back
        self._latest = max(self._latest, base + (read() - zero) * rate)
        return self._latest
