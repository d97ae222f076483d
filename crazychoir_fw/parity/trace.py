"""What is kept of two signals for a small picture: both values and the deviation, at a few hundred instants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

POINTS = 400


@dataclass(frozen=True)
class Trace:
    """Two signals, thinned out for a picture."""

    ticks: NDArray[Any]
    reference: NDArray[np.float64]
    candidate: NDArray[np.float64]
    deviation: NDArray[np.float64]
    """Largest absolute deviation since the instant before; infinite where a sample is unmatched."""


def trace(
    reference: NDArray[Any], candidate: NDArray[Any], ticks: NDArray[Any], turn: float = 0.0, points: int = POINTS
) -> Trace:
    """Thin two signals of shape (T,) out; no deviation between two instants is lost."""
    first, second = reference.astype(np.float64), candidate.astype(np.float64)
    with np.errstate(invalid="ignore"):
        distance = np.abs(first - second)
    distance[(first == second) | (np.isnan(first) & np.isnan(second))] = 0.0
    distance[np.isnan(distance)] = np.inf
    if turn:
        is_finite = np.isfinite(distance)
        rest = np.fmod(distance[is_finite], turn)
        distance[is_finite] = np.minimum(rest, turn - rest)
    starts = np.linspace(0, len(ticks), min(points, len(ticks)), endpoint=False, dtype=np.intp)
    return Trace(ticks[starts], first[starts], second[starts], np.maximum.reduceat(distance, starts))
