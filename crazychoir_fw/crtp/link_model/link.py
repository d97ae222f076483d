"""What a link does to the packets between a server and its drones."""

from __future__ import annotations

import enum
import math
from typing import Any, NamedTuple, Protocol


class Direction(enum.Enum):
    """Which way a packet goes."""

    UP = "up"
    """From the client to the drone."""
    DOWN = "down"
    """From the drone to the client."""


class Arrival(NamedTuple):
    """A packet that has come through."""

    drone: str
    direction: Direction
    datagram: bytes


class Link(Protocol):
    """All simulated Crazyradios of a server. Times are seconds of the server's clock, which never goes back."""

    def send(self, now: float, drone: str, direction: Direction, datagram: bytes, droppable: bool = False) -> None:
        """Take a packet on its way; `droppable` ones may be lost when too much waits."""

    def arrivals(self, now: float) -> list[Arrival]:
        """Return the packets that have come through by now, in the order of their coming."""

    def next_arrival(self) -> float:
        """Return when to ask for arrivals again (s): none comes before; infinity when nothing is under way."""

    def statistics(self) -> dict[str, Any]:
        """Return what has been counted, by radio and by drone, as JSON can hold it (`SimulatedRadios.statistics`)."""


class PerfectLink:
    """Nothing is ever late or lost."""

    def __init__(self) -> None:
        self._arrived: list[Arrival] = []

    def send(self, now: float, drone: str, direction: Direction, datagram: bytes, droppable: bool = False) -> None:
        """Let it arrive at once."""
        self._arrived.append(Arrival(drone, direction, datagram))

    def arrivals(self, now: float) -> list[Arrival]:
        """Return what was sent."""
        arrived, self._arrived = self._arrived, []
        return arrived

    def next_arrival(self) -> float:
        """Return when there is something to fetch: at once, or never."""
        return -math.inf if self._arrived else math.inf

    def statistics(self) -> dict[str, Any]:
        """Nothing is counted, because nothing goes wrong."""
        return {"radios": {}, "drones": {}}
