"""What is counted of the packets of one drone in one direction."""

from __future__ import annotations

import math
from array import array
from itertools import accumulate
from typing import Any

SHORTEST_S = 1e-5
"""Latencies below this count as it."""

PER_DOUBLING = 32
"""Latencies that differ by less than 2^(1/32) = 2 % are not told apart in the 95 % figure."""

BINS = 30 * PER_DOUBLING
"""Up to 3 hours."""


class Tally:
    """Counts of one drone and direction; `sent = delivered + lost + dropped + under_way` at any time."""

    def __init__(self) -> None:
        self.sent = 0
        self.delivered = 0
        self.lost = 0
        """Never got through."""
        self.dropped = 0
        """Did not even leave, because too much was waiting."""
        self.repeated = 0
        """Transmissions beyond the first one of each packet."""
        self.duplicated = 0
        """Arrived once more."""
        self.reordered = 0
        """Arrived after a packet that was sent later."""
        self.most_waiting = 0
        self._sum = 0.0  # [s]
        self._longest = 0.0  # [s]
        self._bins = array("q", bytes(8 * BINS))
        self._newest = -1  # number of the newest packet that has arrived

    @property
    def under_way(self) -> int:
        """Packets that wait or are on their way."""
        return self.sent - self.delivered - self.lost - self.dropped

    def note_waiting(self, count: int) -> None:
        """Remember how many wait."""
        self.most_waiting = max(self.most_waiting, count)

    def note_arrival(self, number: int, latency: float) -> None:
        """Count a packet that has come through, `number` by its sending, after `latency` (s)."""
        self.delivered += 1
        self._sum += latency
        self._longest = max(self._longest, latency)
        place = int(PER_DOUBLING * math.log2(max(latency, SHORTEST_S) / SHORTEST_S))
        self._bins[min(place, BINS - 1)] += 1
        if number < self._newest:
            self.reordered += 1
        self._newest = max(self._newest, number)

    def percentile(self, share: float) -> float | None:
        """Return the latency (s) that this share of the packets does not exceed, to 2 %; None without packets."""
        if not self.delivered:
            return None
        wanted = share * self.delivered
        place = next(place for place, seen in enumerate(accumulate(self._bins)) if seen >= wanted)
        return min(SHORTEST_S * 2.0 ** ((place + 1) / PER_DOUBLING), self._longest)

    def as_dict(self) -> dict[str, Any]:
        """Return all figures, as JSON can hold them; latencies in ms, null without packets."""
        p95 = self.percentile(0.95)
        return {
            "sent": self.sent,
            "delivered": self.delivered,
            "lost": self.lost,
            "dropped": self.dropped,
            "under_way": self.under_way,
            "repeated": self.repeated,
            "duplicated": self.duplicated,
            "reordered": self.reordered,
            "most_waiting": self.most_waiting,
            "latency_mean_ms": 1e3 * self._sum / self.delivered if self.delivered else None,
            "latency_p95_ms": None if p95 is None else 1e3 * p95,
            "latency_max_ms": 1e3 * self._longest if self.delivered else None,
        }
