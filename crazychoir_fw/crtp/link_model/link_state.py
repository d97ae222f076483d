"""What waits for a drone and at a drone, and how its link is, as its dongle knows it."""

from __future__ import annotations

import math
from collections import deque

from crazychoir_fw.crtp.link_model.link import Direction
from crazychoir_fw.crtp.link_model.tally import Tally


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

    def new_parcel(self, direction: Direction, datagram: bytes, now: float) -> QueuedPacket:
        """Return the next packet of one direction, sent now (s), and count it."""
        tally = self.tallies[direction]
        parcel = QueuedPacket(datagram, now, tally.sent)
        tally.sent += 1
        return parcel

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
            self.tallies[direction].lost += sum(not parcel.has_arrived for parcel in waiting)
            given_up += len(waiting)
            waiting.clear()
        return given_up
