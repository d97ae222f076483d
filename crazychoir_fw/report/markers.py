"""Places that explain a flight: targets, intruders. Plain data for plot and film."""

from __future__ import annotations

from dataclasses import dataclass

SHAPES = {"target": "*", "intruder": "v"}
"""How the plot draws each kind."""

COLORS = {"target": "#2A9D4A", "intruder": "#C8281A"}
"""Color of each kind, in plot and film."""


@dataclass(frozen=True)
class Marker:
    """One place."""

    place: tuple[float, float, float]
    """Where (m, world)."""
    kind: str
    """One of `SHAPES`."""
    moves: bool = False
    """Whether it is a drone, which the film shows anyway; the place is where it ends."""
