"""When the next ticks of a world are due, and the clock that a server goes by."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND

MAX_LAG_S = 0.25
"""A simulation that is further behind than this gives the rest up instead of racing after it."""
SLICE_S = 0.002
"""Time (s) from one waking to the next."""
MAX_SLICE = 10
"""Most ticks between two looks at what clients want."""
_RECENT_S = 1.0


class TickPacer:
    """Tells how many ticks to advance. Times are seconds of a clock that goes on evenly."""

    def __init__(self, speed: float | None, ticks_per_step: int = 1) -> None:
        """Set a pace.

        Args:
            speed: Simulated seconds per second; None or 0 is as fast as possible.
            ticks_per_step: Ticks of which only multiples can be advanced by.

        Raises:
            RangeError: If the speed is no number of the range 0 to 1000.
        """
        if speed is not None and not (math.isfinite(speed) and 0.0 <= speed <= 1000.0):
            raise RangeError(f"speed is {speed!r}, allowed: 0 to 1000, where 0 is as fast as possible")
        self.speed = speed or None
        self._ticks_per_step = ticks_per_step
        ticks = SLICE_S * TICKS_PER_SECOND * (speed or 1.0)
        self._slice = self.whole_steps(min(MAX_SLICE, max(1, round(ticks))))
        self._zero = (0.0, 0)  # a time, and the tick that was due then
        self.lag_s = self.worst_lag_s = self.dropped_lag_s = 0.0
        self.resyncs = 0
        self.wall_seconds, self.ticks = 0.0, 0
        self._last: tuple[float, int] | None = None
        self._recent: deque[tuple[float, int]] = deque()

    def begin(self, now: float, tick: int) -> None:
        """Let this tick be due now: at the start, after a pause, and after a jump in time."""
        self._zero = now, tick
        self._last = now, tick
        self.lag_s = 0.0
        self._recent.clear()

    def end(self, now: float, tick: int) -> None:
        """Take the last ticks into account."""
        self._account(now, tick)

    def due(self, now: float, tick: int) -> int:
        """Return by how many ticks to advance from the present one now, 0 to wait."""
        self._account(now, tick)
        if self.speed is None:
            return self.whole_steps(MAX_SLICE)
        begun, first = self._zero
        behind = (now - begun) * self.speed - (tick - first) / TICKS_PER_SECOND  # [s] simulated
        self.lag_s = max(0.0, behind / self.speed)
        self.worst_lag_s = max(self.worst_lag_s, self.lag_s)
        if self.lag_s > MAX_LAG_S:
            self.dropped_lag_s += self.lag_s
            self.resyncs += 1
            self._zero = now, tick
            return self._slice
        ticks = math.floor(behind * TICKS_PER_SECOND + 1e-6)
        if ticks < self._slice:
            return 0
        whole = min(ticks, MAX_SLICE) // self._ticks_per_step * self._ticks_per_step
        return max(self._ticks_per_step, whole)

    def wait_s(self, now: float, tick: int) -> float:
        """Return for how long nothing is due (s)."""
        if self.speed is None:
            return 0.0
        begun, first = self._zero
        return max(0.0, begun + (tick - first + self._slice) / TICKS_PER_SECOND / self.speed - now)

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second, without pauses."""
        return self.ticks / TICKS_PER_SECOND / self.wall_seconds if self.wall_seconds > 0.0 else 0.0

    @property
    def recent_real_time_factor(self) -> float:
        """The same over the last second or so."""
        if len(self._recent) < 2:
            return self.real_time_factor
        (since, first), (until, last) = self._recent[0], self._recent[-1]
        return (last - first) / TICKS_PER_SECOND / (until - since)

    def whole_steps(self, ticks: float) -> int:
        """Return the ticks of as many whole steps as it takes."""
        return -(-round(ticks) // self._ticks_per_step) * self._ticks_per_step

    def _account(self, now: float, tick: int) -> None:
        if self._last is not None:
            self.wall_seconds += now - self._last[0]
            self.ticks += tick - self._last[1]
        self._last = now, tick
        if not self._recent or now - self._recent[-1][0] > 0.1 * _RECENT_S:
            self._recent.append((now, tick))
            while now - self._recent[0][0] > _RECENT_S * 1.1:
                self._recent.popleft()


class Clock:
    """Seconds since some start. Any thread may read it; one thread at a time may change its source."""

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
