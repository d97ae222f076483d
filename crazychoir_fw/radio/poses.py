"""External poses, thinned out to a set rate."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import LARGEST


class PoseGate:
    """Lets so many samples per second through, whatever the rate and regularity of its source.

    Args:
        rate_hz: Samples per second on average, at most.

    Raises:
        RangeError: If it is not above 0.
    """

    def __init__(self, rate_hz: float) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0.0):
            raise RangeError(f"pose_hz is {rate_hz!r}, allowed: a number above 0")
        self._period = 1.0 / rate_hz
        self._due = -math.inf

    def passes(self, now: float) -> bool:
        """Return whether a sample that comes now (s) is to be sent."""
        # a hair early counts: samples that come exactly at the rate would else lose every second one to rounding
        if now < self._due - 1e-3 * self._period:
            return False
        # on the grid of the last one, so that 100 samples per second become 30 and not 25; anew after a gap
        late = now - self._due
        self._due = self._due + self._period if late < self._period else now + self._period
        return True


def usable_pose(
    position: Sequence[float], quat_xyzw: Sequence[float] | None
) -> tuple[tuple[float, ...], tuple[float, ...] | None] | None:
    """Return position (m) and normalized quaternion, or None for a sample without a body in it.

    Motion capture marks a body that it does not see by zeros or by numbers that are not finite.

    Raises:
        RangeError: If one has another shape.
    """
    point = np.asarray(position, float)
    if point.shape != (3,):
        raise RangeError(f"position is {position!r}, allowed: three numbers (m)")
    if not np.all(np.abs(point) <= LARGEST):  # false for what is no number
        return None
    if quat_xyzw is None:
        return tuple(point.tolist()), None
    quat = np.asarray(quat_xyzw, float)
    if quat.shape != (4,):
        raise RangeError(f"quat_xyzw is {quat_xyzw!r}, allowed: four numbers")
    norm = float(np.linalg.norm(quat))
    if not (math.isfinite(norm) and norm > 0.1):
        return None
    return tuple(point.tolist()), tuple((quat / norm).tolist())
