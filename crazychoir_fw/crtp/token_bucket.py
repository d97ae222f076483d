"""How many packets may pass: a token bucket."""

from __future__ import annotations


class TokenBucket:
    """Lets bursts pass up to a size, and a steady stream up to a rate."""

    def __init__(self, rate: float, burst: float) -> None:
        """Begin full.

        Args:
            rate: Packets per second.
            burst: Packets at once.
        """
        self._rate = rate
        self._burst = burst
        self._left = burst
        self._filled_at = 0.0

    def take(self, now: float) -> bool:
        """Take one packet's worth at a time (s) that never goes back. Returns False when there is nothing left."""
        if self._left < self._burst:
            self._left = min(self._burst, self._left + (now - self._filled_at) * self._rate)
        self._filled_at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
