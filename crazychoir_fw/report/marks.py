"""Points beside the drones that explain a flight, such as tasks: for pictures and films."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Mark:
    """A point that is there for a time."""

    position: NDArray[np.float64]
    """Where (m, world), shape (3,)."""
    label: str
    """What is written beside it, short."""
    begin: float
    """From when it is there (s)."""
    end: float
    """Until when (s)."""
    drone: int | None = None
    """Whose it is; None: nobody's so far."""
    link: NDArray[np.float64] | None = None
    """Another point that belongs to it (m, world), shape (3,)."""


@dataclass(frozen=True)
class Stint:
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
class Story:
    """All marks and stints of a flight."""

    marks: Sequence[Mark] = ()
    stints: Sequence[Stint] = ()
    title: str = "tasks"
    """What the stints are about."""
