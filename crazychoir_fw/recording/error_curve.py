"""An error over time, as the page about a flight shows it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.marks import Mark


@dataclass(frozen=True)
class ErrorCurve:
    """Mean and largest of several errors at each sample of a log."""

    label: str
    """What it is, with its unit."""
    mean: NDArray[np.float64]  # (T,)
    largest: NDArray[np.float64]  # (T,)
    limit: float | None = None
    """What is allowed."""
    places: NDArray[np.float64] | None = None  # (N, 3)
    """Target positions of the drones at the end (m); NaN where there is none."""
    ends: NDArray[np.float64] | None = None  # (N, 3)
    """Where they are then (m)."""
    pairs: Sequence[tuple[int, int]] = ()
    """Drones whose bearings count."""
    marks: Sequence[Mark] = ()
    """Points that explain the flight."""
    is_logarithmic: bool = True
    """Whether it is shown on a logarithmic scale; otherwise from zero."""
    note: str = "mean, shaded up to the largest"
    """What line and shade are."""
    judged: tuple[float, float] | None = None
    """From when to when the limit counts (s); None is all the time."""
