"""Where the nose points along a curve."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.planning.curves import Polynomial

_STEP = 0.02  # [s], between samples of a heading along the path
_SLOWEST = 0.05  # [m/s], below which a direction of flight says nothing
_WINDOW = 0.4  # [s], over which corners of the heading are rounded
MAX_YAW_RATE = 2.0
"""How fast the nose turns into the path (rad/s): about a third of what a Crazyflie can."""


class Heading(Protocol):
    """Yaw as a function of the time since the begin of a curve."""

    def at(self, time: float) -> tuple[float, float]:
        """Return yaw (rad) and yaw rate (rad/s)."""
        ...


class FixedHeading:
    """The nose keeps its direction."""

    def __init__(self, yaw: float = 0.0) -> None:
        self._value = (float(yaw), 0.0)

    def at(self, time: float) -> tuple[float, float]:
        """Return yaw (rad) and yaw rate (rad/s)."""
        return self._value


class PathHeading:
    """The nose points where the drone flies to, as seen from above.

    The yaw is continuous and begins at a given one; where the drone is slow it turns toward the next direction. It
    never turns faster than *max_rate*, so that it lags behind in sharp turns.
    """

    def __init__(self, curve: Polynomial, yaw: float = 0.0, max_rate: float = MAX_YAW_RATE) -> None:
        count = max(2, math.ceil(curve.duration / _STEP) + 1)
        times = np.linspace(0.0, curve.duration, count)
        step = times[1]
        wanted = _directions(curve, times, yaw)
        limited = _rate_limited(wanted, yaw, max_rate * step)
        self._yaws = _rounded(limited, step).tolist()
        self._step = float(step)
        self._last = count - 1

    def at(self, time: float) -> tuple[float, float]:
        """Return yaw (rad) and yaw rate (rad/s)."""
        place = time / self._step
        k = int(place)
        if k >= self._last:
            return self._yaws[-1], 0.0
        if place < 0.0:
            return self._yaws[0], 0.0
        change = self._yaws[k + 1] - self._yaws[k]
        return self._yaws[k] + (place - k) * change, change / self._step


def _directions(curve: Polynomial, times: NDArray[np.float64], yaw: float) -> NDArray[np.float64]:
    """Return the direction of flight at *times* without jumps of full turns, shape (n,)."""
    vx, vy = curve.velocity(times)[:, :2].T
    moving = np.hypot(vx, vy) > _SLOWEST
    if not moving.any():
        return np.full(len(times), yaw)
    directions = np.unwrap([yaw, *np.arctan2(vy[moving], vx[moving])])[1:]
    return np.interp(times, times[moving], directions)


def _rate_limited(wanted: NDArray[np.float64], yaw: float, largest: float) -> NDArray[np.float64]:
    values = np.empty(len(wanted))
    for k, goal in enumerate(wanted.tolist()):
        if k:
            yaw += min(max(goal - yaw, -largest), largest)
        values[k] = yaw
    return values


def _rounded(values: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return *values* averaged over a window that shrinks toward both ends, whose values stay."""
    half = int(_WINDOW / 2 / step)
    n = len(values)
    total = np.concatenate([[0.0], np.cumsum(values)])
    k = np.arange(n)
    reach = np.minimum(half, np.minimum(k, n - 1 - k))
    return (total[k + reach + 1] - total[k - reach]) / (2 * reach + 1)
