"""Positions of watched drones that send no messages."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_EARLY = 1e-9  # [s]; times of rounds are sums of periods


class Sightings:
    """The newest positions of some drones, by number.

    Positions count from the round after the one in which they were seen: over topics, the pose of another drone may
    come before or after the own one, and decisions must not depend on that.
    """

    def __init__(self, silence: float) -> None:
        """Begin without sightings.

        Args:
            silence: After which a drone is lost (s).
        """
        self._silence = silence
        self._newest: dict[int, tuple[float, Array]] = {}
        self._older: dict[int, tuple[float, Array]] = {}
        self._seen_at: dict[int, float] = {}

    def see(self, number: int, time: float | None, position: Array, now: float) -> None:
        """Take a position.

        Args:
            number: Of the drone.
            time: When it was there (s); None: now.
            position: Where (m).
            now: Time of the round (s).
        """
        time = now if time is None else time
        newest = self._newest.get(number)
        if newest is None or time != newest[0]:
            self._older[number] = newest or (time, position)
            self._seen_at[number] = now
        self._newest[number] = (time, position)

    def is_lost(self, number: int, now: float) -> bool:
        """Return whether a drone that was seen has not been seen for a while."""
        return number in self._seen_at and now - self._seen_at[number] > self._silence

    def before(self, number: int, now: float) -> Array | None:
        """Return the newest position from before a time (m), None if the drone was never seen."""
        if number not in self._newest:
            return None
        newest = self._newest[number]
        return (newest if newest[0] < now - _EARLY else self._older[number])[1]
