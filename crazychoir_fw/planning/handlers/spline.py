"""Handlers of cubic splines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Reference
from crazychoir_fw.planning.curves import Polynomial, State, cubic_spline
from crazychoir_fw.planning.handlers.forms import FullStateTrajHandler


class Spline(FullStateTrajHandler):
    """A cubic spline through any number of points; velocity and acceleration are given at both ends only."""

    def plan(self, times: NDArray[np.float64], states: Sequence[State]) -> Polynomial:
        """Return the spline through the positions of the states."""
        points = [state.position for state in states]
        if self.legacy:
            return cubic_spline(times, points)
        first, last = states[0], states[-1]
        return cubic_spline(
            times,
            points,
            start_velocity=first.velocity,
            start_acceleration=first.acceleration,
            end_velocity=last.velocity,
            end_acceleration=last.acceleration,
        )


class SplinePosition(Spline):
    """The positions of a `Spline`."""

    kind: ClassVar[str] = "position"

    def _output(self, reference: Reference) -> Reference:
        return Reference(position=reference.position)
