"""Points beside the drones that explain a flight, such as tasks or targets: plain data for pictures and films."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

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
    """Whose it is, and whose color it has; None: nobody's so far."""
    link: NDArray[np.float64] | None = None
    """Another point that belongs to it (m, world), shape (3,)."""
    kind: str = "task"
    """A task, or one of `SHAPES`."""
    moves: bool = False
    """Whether it is a drone, which the film shows anyway; the position is where it ends."""

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
    """Whether it was done then; otherwise it was taken over by somebody else, or given up."""


@dataclass(frozen=True)
class TaskTimeline:
    """All marks and intervals of a flight."""

    marks: Sequence[Mark] = ()
    intervals: Sequence[TaskInterval] = ()
    title: str = "tasks"
    """What the intervals are about."""
