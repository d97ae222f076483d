"""What drones see of each other: nearby flying drones, looked up for the whole swarm at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control.periodic_timer import PeriodicTimer
from crazychoir_fw.control.safety import ClosestRobotGetter
from crazychoir_fw.flight.backend import Indices

Array = NDArray[np.float64]

_STANDING_S = 0.2
"""After this time (s) without another position a drone counts as at rest: it hovers, or its poses are stale."""


class Sensing:
    """Passes the poses of nearby drones to the controllers of a swarm, at its own rate.

    Seen are drones whose motors turn: what lies on the floor is no obstacle for those above. One that is not seen any
    more, though its motors turn, stays where it was seen last, at rest.
    """

    def __init__(
        self, sensing_distance: float = 3.0, rate: float = 100.0, read: Callable[[], Pose] | None = None
    ) -> None:
        """Choose it.

        Args:
            sensing_distance: How far drones see, horizontally (m).
            rate: Looks per second (Hz).
            read: Returns the poses that are seen, arrays of shape (N, 3); None uses the poses that the layers receive.
        """
        self.getter = ClosestRobotGetter(sensing_distance)
        self._read = read
        self._schedule = PeriodicTimer(rate)
        self._asked: float | None = None
        self._gathered = Pose()
        self._last: Array | None = None
        self._moved = np.zeros(0)  # [s], when each was seen to move

    def look(self, now: float, poses: Pose, flying: NDArray[np.bool_]) -> None:
        """Look around, if it is time (s).

        Args:
            now: Time (s).
            poses: Where the drones believe to be, arrays of shape (N, 3).
            flying: Whose motors turn, shape (N,).
        """
        if now == self._asked:
            return  # for another group
        self._asked = now
        if not self._schedule.is_due(now):
            return
        seen = poses if self._read is None else self._read()
        position, velocity = np.array(seen.position, float), np.array(seen.velocity, float)
        if self._last is None or len(self._last) != len(position):
            self._last, self._moved = np.full_like(position, np.nan), np.full(len(position), now)
        self._moved[np.any(position != self._last, axis=1)] = now
        self._last = position.copy()
        velocity[now - self._moved > _STANDING_S] = 0.0
        position[~flying] = np.nan
        self._gathered = self.getter.gathered(Pose(position=position, velocity=velocity))

    def near(self, indices: Indices) -> Pose:
        """Return the poses near each given drone, arrays of shape (n, K, 3); NaN in unused rows."""
        seen = self._gathered
        assert seen.position is not None and seen.velocity is not None
        return Pose(position=seen.position[indices], velocity=seen.velocity[indices])
