"""`VerticalWays`: take-offs and landings of the followers of a bearing formation, computed at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.guidance.cf_guidance import TOUCHDOWN_HEIGHT, Phase

if TYPE_CHECKING:
    from crazychoir_fw.guidance.bearing_formation import BearingFormation

Array = NDArray[np.float64]

VERTICAL = (Phase.TAKEOFF, Phase.LANDING)


class VerticalWays:
    """Followers that climb or descend, straight and with a constant speed; N of them.

    Each computes the same by itself (`BearingFormation.respond`), and needs no message for it.
    """

    def __init__(self, followers: Sequence[BearingFormation]) -> None:
        """Take followers in phases `VERTICAL`; trims of theirs become rows of one array."""
        self.followers = followers
        gains = [one.gains for one in followers]
        self._start = np.array([one.begin_way() for one in followers]).reshape(-1, 3)
        ends = [one.height if one.phase is Phase.TAKEOFF else TOUCHDOWN_HEIGHT for one in followers]
        self._left = np.array(ends) - self._start[:, 2]
        self._speed = np.array([one.height / one.takeoff_time for one in followers])
        self._begin = np.array([one.phase_begin for one in followers])
        self._follows_speed = np.array([one.takeoff_follows_speed for one in gains], bool)
        self._k_p = np.array([np.broadcast_to(one.takeoff_k_p, 3) for one in gains]).reshape(-1, 3)
        self._k_d = np.array([np.broadcast_to(one.takeoff_k_d, 3) for one in gains]).reshape(-1, 3)
        self._k_i = np.array([np.broadcast_to(one.takeoff_k_i, 3) for one in gains]).reshape(-1, 3)
        self._largest_trim = np.array([one.largest_trim for one in gains])[:, None]
        self._largest_squared = np.array([one.largest_acceleration for one in gains]) ** 2
        self._integrates = np.array([one.integrates for one in followers], bool)[:, None]
        self._trims = np.zeros((len(followers), 3))
        for one, trim in zip(followers, self._trims, strict=True):
            one.keep_trim_in(trim)

    def accelerations(self, now: float) -> Array:
        """Return what each asks for (m/s^2, world), shape (N, 3), and learn the trims."""
        if not self.followers:
            return self._trims
        poses = [one.current_pose for one in self.followers]
        positions = np.array([pose.position for pose in poses])  # type: ignore[union-attr]
        velocities = np.array([one.own_velocity for one in self.followers])
        periods = np.array([one.period(now) for one in self.followers])[:, None]
        way, left = self._speed * (now - self._begin), self._left
        is_under_way = self._follows_speed & (way < np.abs(left))
        velocities[:, 2] -= np.where(is_under_way, np.copysign(self._speed, left), 0.0)
        references = self._start.copy()
        references[:, 2] += np.copysign(np.minimum(way, np.abs(left)), left)
        errors = positions - references
        trims = self._trims + np.where(self._integrates, -(self._k_i * errors) * periods, 0.0)
        self._trims[:] = np.clip(trims, -self._largest_trim, self._largest_trim)
        found = self._trims - (self._k_p * errors + self._k_d * velocities)
        squares = np.einsum("ij,ij->i", found, found)
        # they do it themselves where it matters, so that not a bit differs
        for k in np.flatnonzero(squares > 0.999 * self._largest_squared).tolist():
            found[k] = self.followers[k].limited(found[k])
        return found
