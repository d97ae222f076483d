"""The stream of set-points of one drone: when which one is to be sent. No threads, no clock."""

from __future__ import annotations

import math
from collections.abc import Callable

_INFINITE = math.inf


class SetPointStream:
    """Holds the last set-point of a drone, and says when it is to be sent and how long.

    A new set-point goes out at once, unless the last one went out less than a shortest gap ago: then the newest of
    those that came meanwhile goes out at the end of the gap. A set-point that nobody replaces is repeated, because a
    drone levels out when its set-point is 0.5 s old and locks itself after 2 s; when it is older than the time-out, it
    is no longer sent.

    Args:
        keep_alive_hz: Repetitions per second.
        max_rate_hz: Set-points per second at most.
        timeout_s: Age of a set-point that is not repeated any more (s).
    """

    def __init__(self, keep_alive_hz: float, max_rate_hz: float, timeout_s: float) -> None:
        self._repeat_s = 1.0 / keep_alive_hz
        self._gap_s = 1.0 / max_rate_hz
        self._timeout_s = timeout_s
        self._send: Callable[[], None] | None = None
        self._is_new = False
        self._until = _INFINITE
        self._last_sent = -_INFINITE

    def give(self, send: Callable[[], None], now: float, timeout_s: float | None = None) -> None:
        """Replace the set-point.

        Args:
            send: Sends it.
            now: Time (s).
            timeout_s: How long it is repeated (s), in place of the usual time-out.
        """
        self._send, self._is_new = send, True
        self._until = now + (self._timeout_s if timeout_s is None else timeout_s)

    def clear(self) -> None:
        """Send nothing more."""
        self._send, self._is_new, self._until = None, False, _INFINITE

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to send."""
        return self._send is None

    def is_stale(self, now: float) -> bool:
        """Return whether the set-point has been sent and is too old to be repeated."""
        return self._send is not None and not self._is_new and now >= self._until

    def due(self) -> float:
        """Return when there is something to do next (s)."""
        if self._send is None:
            return _INFINITE
        if self._is_new:
            return self._last_sent + self._gap_s
        return min(self._last_sent + self._repeat_s, self._until)

    def take(self, now: float) -> Callable[[], None] | None:
        """Return what is to be sent now, if anything; it then counts as sent."""
        if self._send is None or self.is_stale(now) or now < self.due() - 1e-9:
            return None
        self._last_sent, self._is_new = now, False
        return self._send
