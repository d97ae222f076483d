"""Handlers by what their references carry; both plan degree-7 pieces through the points unless a subclass differs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Reference
from crazychoir_fw.planning.curves import Polynomial, State, through_states
from crazychoir_fw.planning.handlers.handler import TrajectoryHandler


class FullStateTrajHandler(TrajectoryHandler):
    """References are position, velocity, acceleration, jerk, yaw and yaw rate."""

    kind: ClassVar[str] = "fullstate"

    def plan(self, times: NDArray[np.float64], states: Sequence[State]) -> Polynomial:
        """Return a piece of degree 7 between each two states, with all the boundary values that they name."""
        return through_states(states, times)


class AccelerationTrajHandler(FullStateTrajHandler):
    """References are accelerations: for controllers that close no position loop."""

    kind: ClassVar[str] = "acceleration"

    def _output(self, reference: Reference) -> Reference:
        return Reference(acceleration=reference.acceleration)
