"""Kinds of communicators: neighbors that calls name, neighbors that stay, and messages that may be lost."""

from __future__ import annotations

from typing import Any

from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.communicator_interface import Ids


class TimeVaryingCommunicator(TopicCommunicator):
    """Calls name the neighbors of the moment; those given at the start are the largest graph."""


class StaticCommunicator(TopicCommunicator):
    """Neighbors are always those given at the start, whatever a call says."""

    def _named(self, neighbors: Ids | None, all_of_them: tuple[int, ...], what: str) -> tuple[int, ...]:
        del neighbors, what
        return all_of_them

    def has_round(self, neighbors: Ids | None = None) -> bool:
        """Return whether the messages of the open round are all there."""
        del neighbors
        return super().has_round()

    def collect(self, neighbors: Ids | None = None) -> dict[int, Any]:
        """End the open round: return what is there of it, by neighbor, and open the next one."""
        del neighbors
        return super().collect()


class BestEffortCommunicator(TopicCommunicator):
    """The latest message of each neighbor, over a transport that may lose some."""

    reliable = False

    def __init__(
        self,
        agent_id: int,
        size: int,
        in_neighbors: Ids,
        out_neighbors: Ids | None = None,
        differentiated_topics: bool = False,
        *,
        synchronous_mode: bool = False,
        **options: Any,
    ) -> None:
        """Join; the arguments are those of the other communicators."""
        super().__init__(
            agent_id, size, in_neighbors, out_neighbors, synchronous_mode, differentiated_topics, **options
        )
