"""Points beside the drones that explain a flight, such as tasks or targets: plain data for pictures and films."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

SHAPES = {"target": "*", "intruder": "v"}
"""How the plot draws each kind that has a shape and a color of its own; the film draws these as balls."""

COLORS = {"target": "#2A9D4A", "intruder": "#C8281A"}
"""Color of each of them, in plot and film."""


@dataclass(frozen=True)
class Mark:
    """A point that is there all the time, or for a time."""

    position: NDArray[np.float64]
    """Where (m, world), shape (3,)."""
    label: str = ""
    """What is written beside it, short."""
    begin: float = -math.inf
    """From when it is there (s)."""
    end: float = math.inf
    """Until when (s)."""
    drone: int | None = None
    """Number of the drone that it is assigned to, and whose color it has; None while it is unassigned."""
    link: NDArray[np.float64] | None = None
    """Another point that belongs to it (m, world), shape (3,)."""
    kind: str = "task"
    """A task, or one of `SHAPES`."""
    moves: bool = False
    """Whether it is a drone, which the film shows anyway; the position is where it ends."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON can hold it; `from_dict` reads that. What is as usual is left out."""
        values = {
            "position": [float(value) for value in self.position],
            "label": self.label,
            "begin": None if math.isinf(self.begin) else float(self.begin),
            "end": None if math.isinf(self.end) else float(self.end),
            "drone": None if self.drone is None else int(self.drone),
            "link": None if self.link is None else [float(value) for value in self.link],
            "kind": self.kind,
            "moves": self.moves or None,
        }
        return {key: value for key, value in values.items() if value is not None}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Mark:
        """Read what `as_dict` wrote.

        Raises:
            KeyError: If there is no position.
            ValueError: If a place is not three finite numbers.
        """
        link = entry.get("link")
        for place in (entry["position"], *(() if link is None else (link,))):
            if len(place) != 3 or not all(math.isfinite(value) for value in place):
                raise ValueError(f"a mark is at {place}, allowed: three finite numbers")
        return cls(
            np.array(entry["position"], float),
            str(entry.get("label", "")),
            float(entry.get("begin", -math.inf)),
            float(entry.get("end", math.inf)),
            None if entry.get("drone") is None else int(entry["drone"]),
            None if link is None else np.array(link, float),
            str(entry.get("kind", "task")),
            bool(entry.get("moves", False)),
        )

    def is_there(self, now: float) -> bool:
        """Tell whether it is there at a time (s)."""
        return self.begin <= now < self.end


@dataclass(frozen=True)
class TaskInterval:
    """What a drone worked on for a time."""

    drone: int
    """Which one."""
    begin: float
    """From when (s)."""
    end: float
    """Until when (s)."""
    label: str
    """On what."""
    is_finished: bool
    """Whether it was done then; otherwise another drone took it over, or it was given up."""


@dataclass(frozen=True)
class TaskTimeline:
    """All marks and intervals of a flight."""

    marks: Sequence[Mark] = ()
    intervals: Sequence[TaskInterval] = ()
    title: str = "tasks"
    """What the intervals are about."""
