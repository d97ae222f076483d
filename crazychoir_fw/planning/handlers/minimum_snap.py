"""Handler of curves of least snap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.planning.curves import Polynomial, State, minimum_snap
from crazychoir_fw.planning.handlers.forms import FullStateTrajHandler


class MinimumSnap(FullStateTrajHandler):
    """The curve of least snap through the points.

    A point between the ends fixes the velocity there only where it names one other than 0: senders fill in zeros.
    """

    def plan(self, times: NDArray[np.float64], states: Sequence[State]) -> Polynomial:
        """Return the curve through the positions of the states, with all that the first and the last name."""
        first, last = states[0], states[-1]
        inner = [state.velocity if state.velocity.any() else None for state in states[1:-1]]
        return minimum_snap(
            times,
            [state.position for state in states],
            velocities=[None, *inner, None],
            start=(first.velocity, first.acceleration, first.jerk),
            end=(last.velocity, last.acceleration, last.jerk),
        )
