"""Degree-7 polynomials from boundary values (docs/reference/crazychoir.md#7.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning.curves.polynomial import Polynomial
from crazychoir_fw.planning.curves.state import State


def septic(start: State, end: State, duration: float) -> NDArray[np.float64]:
    """Return the coefficients of the polynomial of degree 7 between two states, shape (axes, 8)."""
    if not 0.0 < duration < np.inf:
        raise RangeError(f"a curve of {duration} s, allowed: above 0 s")
    T = duration
    p0, v0, a0, j0 = (np.asarray(x, dtype=float) for x in _values(start))
    p1, v1, a1, j1 = (np.asarray(x, dtype=float) for x in _values(end))
    h = p1 - p0
    return np.stack(
        [
            p0,
            v0,
            a0 / 2,
            j0 / 6,
            (210 * h - T * ((120 * v0 + 90 * v1) + (30 * a0 - 15 * a1) * T + (4 * j0 + j1) * T**2)) / (6 * T**4),
            (-168 * h + T * ((90 * v0 + 78 * v1) + (20 * a0 - 14 * a1) * T + (2 * j0 + j1) * T**2)) / (2 * T**5),
            (420 * h - T * ((216 * v0 + 204 * v1) + (45 * a0 - 39 * a1) * T + (4 * j0 + 3 * j1) * T**2)) / (6 * T**6),
            (-120 * h + T * ((60 * v0 + 60 * v1) + (12 * a0 - 12 * a1) * T + (j0 + j1) * T**2)) / (6 * T**7),
        ],
        axis=-1,
    )


def point_to_point(start: State, end: State, duration: float) -> Polynomial:
    """Return the curve of degree 7 between two states: position to jerk are those asked for at both ends.

    Args:
        start: State at time 0.
        end: State at *duration*.
        duration: Above 0 s.
    """
    return Polynomial([duration], septic(start, end, duration)[None])


def through_states(states: Sequence[State], times: Sequence[float]) -> Polynomial:
    """Return degree-7 pieces through states at increasing times (s); the first one counts as the begin."""
    durations = np.diff(np.asarray(times, dtype=float))
    pieces = [septic(a, b, float(T)) for a, b, T in zip(states[:-1], states[1:], durations, strict=True)]
    return Polynomial(durations, pieces)


def _values(state: State) -> tuple[NDArray[np.float64], ...]:
    return state.position, state.velocity, state.acceleration, state.jerk
