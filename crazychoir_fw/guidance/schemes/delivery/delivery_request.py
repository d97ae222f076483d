"""One request: something is to be brought from one point to another."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DeliveryRequest:
    """A load with its way."""

    number: int
    """Its place in the table."""
    pickup: tuple[float, float]
    """Where it is (m, world)."""
    delivery: tuple[float, float]
    """Place of the delivery (m, world)."""
    load: float = 1.0
    """How much it takes of a drone's capacity."""
    carrier: int | None = None
    """Number of the drone that has it on board; None: no drone."""
    at: float = 0.0
    """When it turns up, after the first list (s)."""
