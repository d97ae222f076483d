"""Handler of curves of least snap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning.allocation import allocate_times
from crazychoir_fw.planning.curves import Polynomial, State, minimum_snap
from crazychoir_fw.planning.handlers.forms import FullStateTrajHandler
from crazychoir_fw.planning.limits import GENTLE, LimitReport


class MinimumSnap(FullStateTrajHandler):
    """The curve of least snap through the points.

    A point between the ends fixes the velocity there only where it names one other than 0: senders fill in zeros.
    """

    def __init__(
        self, update_frequency: float = 100.0, input_topic: str | None = None, *, times: str = "given", **options: Any
    ) -> None:
        """Make a handler without a trajectory.

        Args:
            update_frequency: How often `evaluate` is meant to be called (Hz).
            input_topic: Topic on which a controller takes the references; None is the name of the kind.
            times: "given" flies at the times of the points; "free" ignores them and finds the shortest ones within the
                limits, which are gentle ones where none are given.
            options: As for `TrajectoryHandler`.
        """
        super().__init__(update_frequency, input_topic, **options)
        if times not in ("given", "free"):
            raise RangeError(f"{self}: times is {times!r}, allowed: 'given' or 'free'")
        self._is_timed = times == "given"

    def plan(self, times: NDArray[np.float64], states: Sequence[State]) -> Polynomial:
        """Return the curve through the positions of the states, with all that the first and the last name."""
        return minimum_snap(times, _positions(states), **_boundaries(states))

    def _within_limits(
        self, times: NDArray[np.float64], states: Sequence[State]
    ) -> tuple[Polynomial, LimitReport | None]:
        if self._is_timed:
            return super()._within_limits(times, states)
        # a drone in flight may be beyond a limit already: it still needs a curve
        found = allocate_times(_positions(states), self.limits or GENTLE, is_strict=False, **_boundaries(states))
        return found.curve, found.report


def _positions(states: Sequence[State]) -> list[NDArray[np.float64]]:
    return [state.position for state in states]


def _boundaries(states: Sequence[State]) -> dict[str, Any]:
    first, last = states[0], states[-1]
    inner = [state.velocity if state.velocity.any() else None for state in states[1:-1]]
    return {
        "velocities": [None, *inner, None],
        "start": (first.velocity, first.acceleration, first.jerk),
        "end": (last.velocity, last.acceleration, last.jerk),
    }
