"""When something is due that happens so often per second."""

from __future__ import annotations

import math

from crazychoir_fw.common.errors import RangeError

_EARLY = 1e-6  # of a period: clocks are floats


class PeriodicTimer:
    """Is due at the first call of `is_due`, and from there at whole multiples of its period.

    Periods are counted, so that nothing drifts. Missed periods are skipped. A clock that goes back, because a world was
    reset, restarts the count.
    """

    def __init__(self, frequency: float) -> None:
        """Make a schedule of a frequency (Hz)."""
        self.frequency = frequency
        self._start = math.nan
        self._count = 0
        self._last = math.inf

    @property
    def period(self) -> float:
        """Time between two due instants (s)."""
        return 1.0 / self.frequency

    def is_due(self, now: float) -> bool:
        """Return whether an instant is due at a time (s); each instant is due once."""
        if now < self._last:
            self._start, self._count = now, 0
        self._last = now
        periods = (now - self._start) * self.frequency + _EARLY
        if periods < self._count:
            return False
        self._count = math.floor(periods) + 1
        return True


def checked_frequency(who: str, name: str, frequency: float) -> float:
    """Return a frequency (Hz).

    Raises:
        RangeError: If it is not above 0 and finite; the message says whose it is.
    """
    try:
        value = float(frequency)
    except (TypeError, ValueError):
        value = math.nan
    if not 0.0 < value < math.inf:
        raise RangeError(f"{who}: {name} is {frequency!r}, allowed: above 0 Hz")
    return value
