"""When to be at each waypoint: as early as limits allow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.planning.curves import Polynomial, minimum_snap
from crazychoir_fw.planning.curves.minimum_snap import snap_gradient
from crazychoir_fw.planning.curves.waypoints import checked_points
from crazychoir_fw.planning.limits import GENTLE, LimitReport, Limits, fit_duration

Array = NDArray[np.float64]

_SHORTEST = 0.1  # [s], between two waypoints
_ITERATIONS = 60


@dataclass(frozen=True)
class Allocation:
    """A curve of least snap with the times that were found for it."""

    times: Array
    """When each waypoint is reached (s), shape (m,)."""
    curve: Polynomial
    """The curve."""
    report: LimitReport
    """What it asks for of the limits; says which one binds."""
    guess_duration: float
    """How long the curve would take with the times of the guess, stretched to the same limits (s)."""


def trapezoidal_times(points: ArrayLike, limits: Limits = GENTLE) -> Array:
    """Return when points would be reached by stopping at each, with speed and acceleration of the limits.

    Args:
        points: Shape (m, axes).
        limits: Without an acceleration, 2 m/s^2; without a speed, none is too fast.

    Returns:
        Times from 0 (s), shape (m,). Points are at least 0.1 s apart.
    """
    q = checked_points("trapezoidal_times", points)
    a, v = limits.acceleration or GENTLE.acceleration, limits.speed or np.inf
    distance = np.linalg.norm(np.diff(q, axis=0), axis=1)
    # a triangle of speed where the top speed is not reached
    durations = np.where(distance * a < v * v, 2.0 * np.sqrt(distance / a), distance / v + v / a)
    return np.concatenate([[0.0], np.cumsum(np.maximum(durations, _SHORTEST))])


def allocate_times(
    points: ArrayLike,
    limits: Limits = GENTLE,
    *,
    velocities: Sequence[ArrayLike | None] | None = None,
    start: Sequence[ArrayLike] = (),
    end: Sequence[ArrayLike] = (),
    is_strict: bool = True,
) -> Allocation:
    """Find times for a curve of least snap through points, and the curve.

    The guess stops at each point. Then durations are shifted between the pieces, their sum kept, for the least snap
    (D. Mellinger, V. Kumar, "Minimum snap trajectory generation and control for quadrotors", ICRA 2011), by gradient
    descent; last, all are stretched or shrunk together until the first limit binds. If the guess then takes no longer,
    it is kept.

    Args:
        points: Shape (m, 3), m at least 2.
        limits: At least one must be set.
        velocities: As for `minimum_snap`.
        start: The same.
        end: The same.
        is_strict: Refuse a curve that begins or ends beyond a limit, so that none keeps within.

    Raises:
        RangeError: If the points make no curve, nothing is limited, or the curve is refused.
    """
    q = checked_points("allocate_times", points)
    given = {"velocities": velocities, "start": start, "end": end}

    def fitted(times: Array) -> tuple[Array, Polynomial, LimitReport]:
        plan = lambda factor: minimum_snap(times * factor, q, **given)
        curve, factor, report = fit_duration(plan, limits, may_shrink=True)
        return times * factor, curve, report

    guess = fitted(trapezoidal_times(q, limits))
    if guess[2].binding is None:
        raise RangeError("allocate_times: nothing is limited, so the fastest curve takes no time")
    better = fitted(_least_snap(guess[0], q, given))
    # a curve that keeps within limits first, then the shorter one
    times, curve, report = min((better, guess), key=lambda found: (not found[2].holds, found[1].duration))
    if is_strict and not report.holds:
        load = report.binding
        raise RangeError(
            f"allocate_times: {load.name} is {load.peak:.3g} at {load.time:.3g} s however slowly it flies, "
            f"allowed: {load.allowed:.3g}"
        )
    return Allocation(times, curve, report, guess[1].duration)


def _least_snap(times: Array, q: Array, given: dict) -> Array:
    """Return times of the same total for which the integral of squared snap is less."""
    if len(q) == 2:
        return times
    total = times[-1]

    def solve(x: Array) -> tuple[Array, float, Array]:
        durations = np.exp(x - x.max())
        durations *= total / durations.sum()
        curve = minimum_snap(np.concatenate([[0.0], np.cumsum(durations)]), q, **given)
        cost, slopes = snap_gradient(curve)
        # of the logarithm of the cost by x, where durations are total * softmax(x)
        return durations, cost, durations * (slopes - slopes @ durations / total) / cost

    x = np.log(np.diff(times))
    durations, cost, gradient = solve(x)
    if cost <= 0.0:
        return times
    step = 0.1
    for _ in range(_ITERATIONS):
        # shorter steps until the cost falls enough; no duration changes more than by half at once
        step = min(step, 0.4 / max(np.abs(gradient).max(), 1e-12))
        for _ in range(12):
            candidate = solve(x - step * gradient)
            if np.log(candidate[1] / cost) <= -1e-4 * step * gradient @ gradient:
                break
            step *= 0.3
        else:
            break
        moved, turned = -step * gradient, candidate[2] - gradient
        x, is_converged = x + moved, cost - candidate[1] < 1e-5 * cost
        durations, cost, gradient = candidate
        if is_converged:
            break
        # step length of Barzilai and Borwein
        curvature = moved @ turned
        step = moved @ moved / curvature if curvature > 0.0 else 2.0 * step
    return np.concatenate([[0.0], np.cumsum(durations)])
