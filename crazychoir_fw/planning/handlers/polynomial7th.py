"""Handler of degree-7 polynomials."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.planning.curves import Polynomial, State
from crazychoir_fw.planning.handlers.forms import FullStateTrajHandler


class Polynomial7th(FullStateTrajHandler):
    """Degree 7 from point to point: all boundary values up to the jerk are those of the points.

    The original knows but the last point of a message; this one flies through all, with the velocity that each names,
    which is a stop where it names none.
    """

    def plan(self, times: NDArray[np.float64], states: Sequence[State]) -> Polynomial:
        """Return a piece of degree 7 between each two states."""
        if self.legacy:
            times, states = times[[0, -1]], [states[0], states[-1]]
        return super().plan(times, states)

    def _place(self, position: NDArray[np.float64], start: NDArray[np.float64], is_path: bool) -> NDArray[np.float64]:
        # the original mirrors only what it draws as a spline
        return position if self.legacy else super()._place(position, start, is_path)
