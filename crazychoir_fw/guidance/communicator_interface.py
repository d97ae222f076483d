"""What algorithms ask of a communicator, and what each of them counts (docs/reference/crazychoir.md#17.2)."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from crazychoir_fw.common.checkpoint import Stateful

Ids = Iterable[int]


@dataclass
class Statistics:
    """What a communicator has seen."""

    rounds: int = 0
    """Rounds that ended."""
    sent: int = 0
    """Messages that were published."""
    received: int = 0
    """Messages that came."""
    lost: int = 0
    """Messages that were not there when their round ended."""
    cut: int = 0
    """Messages that came over an edge which the graph of the moment does not have."""
    late: int = 0
    """Messages that came when their round was over, or were skipped."""
    refused: int = 0
    """Messages that were none, or came when too many were waiting."""
    jumps: int = 0
    """How often a label was taken over from others."""
    bytes_sent: int = 0
    """Bytes that were published; 0 where objects travel."""
    bytes_received: int = 0
    """Bytes that came; 0 where objects travel."""


class Communicator(Stateful, ABC):
    """What algorithms ask of any communicator, in DISROPT's words.

    Attributes:
        rank: Number of this agent.
        size: Number of agents.
        current_label: Label of the round that is open. May be set forward, to begin a new series of rounds.
        in_neighbors: Agents that this one may receive from.
        out_neighbors: Agents that may receive from this one.
    """

    rank: int
    size: int
    current_label: int
    in_neighbors: tuple[int, ...]
    out_neighbors: tuple[int, ...]

    @abstractmethod
    def neighbors_send(self, obj: object, neighbors: Ids | None = None) -> None:
        """Send an object as the message of the open round."""

    @abstractmethod
    def neighbors_receive(
        self,
        neighbors: Ids | None = None,
        stop_event: threading.Event | None = None,
        timeout: float | None = None,
    ) -> dict[int, Any]:
        """Wait for the messages of the open round and end it."""

    @abstractmethod
    def neighbors_receive_asynchronous(self, neighbors: Ids | None = None) -> dict[int, Any]:
        """Return what came since the last call, the latest of each neighbor, without waiting."""

    @abstractmethod
    def neighbors_exchange(
        self,
        obj: object,
        in_neighbors: Ids | None = None,
        out_neighbors: Ids | None = None,
        dict_neigh: bool = False,
        stop_event: threading.Event | None = None,
        timeout: float | None = None,
    ) -> dict[int, Any]:
        """Send, then receive."""
