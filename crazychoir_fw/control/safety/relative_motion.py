"""How agents move relative to those near them, in the horizontal plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.onboard.arrays import doubles, filled_by_core

Array = NDArray[np.float64]


class RelativeMotion(NamedTuple):
    """Motion of N agents, relative to K others each."""

    velocity: Array
    """Own velocities (m/s), shape (N, 2)."""
    offset: Array
    """Own position minus the other's (m), shape (N, K, 2); infinite for padding."""
    closing: Array
    """Own velocity minus the other's (m/s), shape (N, K, 2)."""

    @classmethod
    def of(cls, own_position: Array, own_velocity: Array, position: Array, velocity: Array) -> RelativeMotion:
        """Return the motion of agents, flat; agents of unknown position are at infinity, at rest.

        Args:
            own_position: Of the agents (m), shape (..., 2) or (..., 3).
            own_velocity: Of the agents (m/s), of the same shape.
            position: Of those near each (m), shape (..., K, 2) or (..., K, 3), padded with nan.
            velocity: Of those near each (m/s), of the same shape; where it is nan the closing velocity is 0.
        """
        near, axes = position.shape[-2:]
        agents = own_position.size // axes
        offset, closing = np.empty((2, agents, near, 2))
        lib.cf_relative_motion(
            agents,
            near,
            axes,
            doubles(own_position, own_position.shape),
            doubles(own_velocity, own_position.shape),
            doubles(position, position.shape),
            doubles(velocity, position.shape),
            filled_by_core(offset),
            filled_by_core(closing),
        )
        return cls(own_velocity.reshape(agents, axes)[:, :2], offset, closing)

    def of_some(self, agents: NDArray[np.intp]) -> RelativeMotion:
        """Return the motion of some of the agents."""
        return RelativeMotion(*(part[agents] for part in self))
