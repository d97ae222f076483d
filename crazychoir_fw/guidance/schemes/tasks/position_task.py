"""One task of the table: a point that one drone must visit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PositionTask:
    """A point to be visited."""

    number: int
    """Its place in the table, [0, N - 1]; taken over by a new task when this one is done."""
    sequence: int
    """Its number among all tasks there ever were."""
    position: tuple[float, float]
    """Where (m, world)."""
    agents: tuple[int, ...]
    """Numbers of the agents that can do it."""
