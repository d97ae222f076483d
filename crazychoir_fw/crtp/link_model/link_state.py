"""What waits for a drone and at a drone, and how its link is, as its dongle knows it."""

from __future__ import annotations

import math
from array import array
from collections import deque
from itertools import accumulate
from typing import Any

from crazychoir_fw.crtp.link_model.link import Direction


class QueuedPacket:
    """A packet that waits or is on its way."""

    __slots__ = ("datagram", "has_arrived", "number", "sent", "was_tried")

    def __init__(self, datagram: bytes, sent: float, number: int) -> None:
        self.datagram = datagram
        self.sent = sent  # [s]
        self.number = number  # among those of its drone and direction
        self.was_tried = False
        self.has_arrived = False  # at the drone, which may not have been understood


class LinkState:
    """What a dongle knows of one of its drones."""

    def __init__(self, drone: str) -> None:
        self.drone = drone
        self.up: deque[QueuedPacket] = deque()
        self.down: deque[QueuedPacket] = deque()
        self.tallies = {Direction.UP: Tally(), Direction.DOWN: Tally()}
        self.last_arrival = {Direction.UP: -math.inf, Direction.DOWN: -math.inf}  # [s]
        self.next_poll = -math.inf  # [s]
        self.is_lost = False
        self.lost_links = 0
        self.failed = 0  # exchanges in a row
        self.failing_since = math.inf  # [s]

    def ready_at(self) -> float:
        """Return from when on the dongle turns to this drone (s)."""
        poll = math.inf if self.is_lost else self.next_poll
        return min(poll, self.up[0].sent) if self.up else poll

    def new_packet(self, direction: Direction, datagram: bytes, now: float) -> QueuedPacket:
        """Return the next packet of one direction, sent now (s), and count it."""
        tally = self.tallies[direction]
        packet = QueuedPacket(datagram, now, tally.sent)
        tally.sent += 1
        return packet

    def note_acknowledged(self) -> None:
        """Remember that the drone is there."""
        self.is_lost = False
        self.failed = 0
        self.failing_since = math.inf

    def lose_link(self) -> int:
        """Give up what waits, and return how many packets that were."""
        self.lost_links += not self.is_lost
        self.is_lost = True
        self.failed = 0
        self.failing_since = math.inf
        given_up = 0
        for direction, waiting in ((Direction.UP, self.up), (Direction.DOWN, self.down)):
            self.tallies[direction].lost += sum(not packet.has_arrived for packet in waiting)
            given_up += len(waiting)
            waiting.clear()
        return given_up


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
