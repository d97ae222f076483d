"""Tables that drones work for: tasks, and requests of deliveries."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from crazychoir_fw.common.constraints import number, point, whole
from crazychoir_fw.mission.section import Section


class TasksLayer(Section):
    """The table that `TaskGuidance` works for: points to be visited, always as many as drones."""

    seed: Annotated[int, whole(0, 2**32 - 1)] = 4
    """Seed of the draws."""

    low: Annotated[tuple[float, ...], point("x", "y")] = (-3.0, -3.0)
    """Least x and y of a point (m)."""

    high: Annotated[tuple[float, ...], point("x", "y")] = (3.0, 3.0)
    """Largest x and y of a point (m)."""

    probability: Annotated[float, number(0.01, 1.0)] = 0.5
    """That a drone can do a task."""

    generations: Annotated[int, whole(1, 10_000)] = 8
    """How often tasks are drawn: once at START, then after each completion."""

    deadline: Annotated[float, number(0.1, 60.0, "s")] = 1.0
    """A drone that does not request its tasks for so long after a new list counts as lost (s)."""

    patience: Annotated[float, number(1.0, 3600.0, "s")] = 30.0
    """After so long without a completion tasks are reassigned (s)."""


class RequestEntry(Section):
    """Something that is to be brought from one point to another."""

    pickup: Annotated[tuple[float, ...], point("x", "y")]
    """Where it is (m)."""

    delivery: Annotated[tuple[float, ...], point("x", "y")]
    """Where it shall be (m)."""

    load: Annotated[float, number(0.0, 1000.0)] = 1.0
    """How much it takes of the capacity of a drone."""

    at: Annotated[float, number(0.0, 36000.0, "s")] = 0.0
    """When it turns up, after START (s)."""


class DeliveryLayer(Section):
    """The table that `DeliveryGuidance` works for."""

    requests: Annotated[list[RequestEntry], Field(min_length=1, max_length=64)]
    """What is to be brought where."""

    deadline: Annotated[float, number(0.1, 60.0, "s")] = 1.0
    """A drone that does not request its list for so long counts as lost (s)."""

    patience: Annotated[float, number(1.0, 3600.0, "s")] = 30.0
    """After so long without a pickup or a delivery routes are replanned (s)."""
