"""Trajectories for the memory of a Crazyflie, and for missions (docs/reference/planner-commander.md#4.1 and #5.1).

The memory holds pieces of degree 7 of x, y, z and yaw. Curves of at most that degree fit exactly; a yaw along the path,
and curves of more pieces than there is room for, are fitted, and what is lost is measured.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.common.trajectory_files import MEMORY_PIECES, write_pieces
from crazychoir_fw.onboard.trajectories import (
    CompressedSegment,
    CompressedStart,
    compress,
    decompress,
    pack_compressed,
)
from crazychoir_fw.planning.curves import Polynomial
from crazychoir_fw.planning.headings import FixedHeading
from crazychoir_fw.planning.trajectory import Trajectory

Array = NDArray[np.float64]

MEMORY_BYTES = 4096
"""Trajectory memory of a Crazyflie."""

YAW_TOLERANCE = 0.01
"""Pieces are halved while a yaw along the path is farther off (rad)."""

_SIZE = 8  # coefficients of a piece
_SAMPLES = 24  # of a piece that is fitted
_SHORTEST = 0.02  # [s], a piece that is halved no further; files of missions take 0.01 s


@dataclass(frozen=True)
class OnboardPieces:
    """What `HighLevelCommander.upload_trajectory` takes."""

    rows: NDArray[np.float32]
    """8 ascending coefficients of x, y, z (m) and yaw (rad), then the duration (s), shape (n, 33)."""
    position_error: float
    """How far it is from the trajectory at most (m)."""
    yaw_error: float
    """The same for the yaw (rad)."""

    def write(self, path: Path | str) -> None:
        """Write the file that phases ``trajectory:`` of missions read."""
        with replacing(Path(path)) as temporary:
            write_pieces(temporary, self.rows)


@dataclass(frozen=True)
class OnboardCompressed:
    """What `HighLevelCommander.upload_compressed_trajectory` takes."""

    start: CompressedStart
    """Where it starts."""
    segments: list[CompressedSegment]
    """What follows."""
    size: int
    """Bytes of trajectory memory."""
    position_error: float
    """How far it is from the trajectory at most, rounding to 1 mm and 1 ms included (m)."""
    yaw_error: float
    """The same for the yaw (rad)."""


def to_pieces(trajectory: Trajectory | Polynomial, *, max_pieces: int = MEMORY_PIECES) -> OnboardPieces:
    """Return a trajectory as uncompressed pieces.

    Args:
        trajectory: What to fly; a curve alone keeps yaw 0.
        max_pieces: Neighbors are fitted by one piece, those first where least is lost, until no more are left.
    """
    trajectory = _trajectory(trajectory)
    if max_pieces < 1:
        raise RangeError(f"to_pieces: max_pieces is {max_pieces}, allowed: 1 or more")
    curve = trajectory.curve
    knots = _merged(curve, max_pieces)
    yaws = [_fitted_yaw(trajectory, a, b) for a, b in pairwise(knots)]
    # the yaw takes what room is left
    while len(yaws) < max_pieces:
        worst = max(range(len(yaws)), key=lambda k: yaws[k][1])
        a, b = knots[worst], knots[worst + 1]
        if yaws[worst][1] <= YAW_TOLERANCE or b - a < 2 * _SHORTEST:
            break
        middle = (a + b) / 2
        knots.insert(worst + 1, middle)
        yaws[worst : worst + 1] = [_fitted_yaw(trajectory, a, middle), _fitted_yaw(trajectory, middle, b)]

    rows = np.zeros((len(yaws), 4 * _SIZE + 1))
    for row, a, b, (yaw, _) in zip(rows, knots[:-1], knots[1:], yaws, strict=True):
        row[: 3 * _SIZE] = _fitted(curve, a, b)[0].ravel()
        row[3 * _SIZE : -1] = yaw
        row[-1] = b - a
    rows = rows.astype(np.float32)
    return OnboardPieces(rows, *_errors(trajectory, rows))


def to_compressed(trajectory: Trajectory | Polynomial, *, tolerance: float = 0.001) -> OnboardCompressed:
    """Return a trajectory in the compressed form, which takes a fourth of the memory or less, in whole millimeters.

    Args:
        trajectory: What to fly; a curve alone keeps yaw 0.
        tolerance: What shorter forms of single axes may be off (m, rad).
    """
    trajectory = _trajectory(trajectory)
    # yaw along a path is cut finer than the knots of the curve; the shortest segment has 3 bytes
    pieces = max(2 * len(trajectory.curve), MEMORY_PIECES)
    while True:
        rows = _whole_milliseconds(to_pieces(trajectory, max_pieces=pieces).rows)
        start, segments = compress(rows, tolerance)
        size = len(pack_compressed(start, segments))
        if size <= MEMORY_BYTES:
            break
        pieces = min(pieces - 1, int(len(segments) * MEMORY_BYTES / size))
    return OnboardCompressed(start, segments, size, *_errors(trajectory, decompress(start, segments)))


def _whole_milliseconds(rows: NDArray[np.float32]) -> Array:
    """Return pieces that begin at whole milliseconds; each path stays, so that what is rounded does not add up."""
    rows = rows.astype(float)
    knots = np.concatenate([[0.0], np.cumsum(rows[:, -1])])
    durations = np.maximum(np.diff(np.round(knots, 3)), 0.001)
    stretch = rows[:, -1] / durations
    rows[:, :-1] *= np.tile(stretch[:, None] ** np.arange(_SIZE), 4)
    rows[:, -1] = durations
    return rows


def _trajectory(trajectory: Trajectory | Polynomial) -> Trajectory:
    return Trajectory(trajectory, FixedHeading()) if isinstance(trajectory, Polynomial) else trajectory


def _merged(curve: Polynomial, most: int) -> list[float]:
    """Return knots (s) of at most so many pieces; neighbors are merged where the fit loses least."""
    knots = dict(enumerate(curve.knots.tolist()))
    after = {k: k + 1 for k in range(len(curve))}
    before = {k + 1: k for k in range(len(curve))}
    excess = len(curve) - most
    if excess <= 0:
        return list(knots.values())

    def loss(k: int) -> tuple[float, int, float, float]:
        a, b = knots[before[k]], knots[after[k]]
        return _fitted(curve, a, b)[1], k, a, b

    queue = [loss(k) for k in range(1, len(curve))]
    heapq.heapify(queue)
    while excess:
        _, k, a, b = heapq.heappop(queue)
        # a neighbor may have been merged since
        if k not in knots or (knots[before[k]], knots[after[k]]) != (a, b):
            continue
        low, high = before.pop(k), after.pop(k)
        del knots[k]
        after[low], before[high] = high, low
        excess -= 1
        for neighbor in (low, high):
            if neighbor in before and neighbor in after:
                heapq.heappush(queue, loss(neighbor))
    return [knots[k] for k in sorted(knots)]


def _fitted(curve: Polynomial, a: float, b: float) -> tuple[Array, float]:
    """Return coefficients of degree 7 over [a, b], shape (axes, 8), and how far they are off at most (m)."""
    piece = int(np.clip(np.searchsorted(curve.knots, a, side="right") - 1, 0, len(curve) - 1))
    if b <= curve.knots[piece + 1] and curve.coefficients.shape[2] <= _SIZE:
        return _shifted(curve.coefficients[piece], a - curve.knots[piece]), 0.0

    # position, velocity and acceleration of both ends are kept; the two free coefficients of degree 7 are a fit of
    # least squares
    T = b - a
    begin = [curve.at(a, order) * T**order for order in range(3)]
    # the end belongs to the piece before it
    end = [curve.at(np.nextafter(b, a), order) * T**order for order in range(3)]
    value = _QUINTIC @ np.array(begin + end)
    s = np.linspace(0.0, 1.0, _SAMPLES * max(1, int(np.searchsorted(curve.knots, b) - piece)) + 1)
    rest = curve.at(a + s * T) - s[:, None] ** np.arange(6) @ value
    basis = (s * (1 - s))[:, None] ** 3 * s[:, None] ** np.arange(2)
    weights = np.linalg.lstsq(basis, rest, rcond=None)[0]
    off = float(np.linalg.norm(rest - basis @ weights, axis=1).max())
    unit = np.zeros((_SIZE, curve.axes))
    unit[:6] = value
    unit += _BUMPS @ weights
    return (unit / T ** np.arange(_SIZE)[:, None]).T, off


def _fitted_yaw(trajectory: Trajectory, a: float, b: float) -> tuple[Array, float]:
    """Return coefficients of the yaw over [a, b], shape (8,), and how far they are off at most (rad)."""
    heading, T = trajectory.heading, b - a
    coefficients = np.zeros(_SIZE)
    if isinstance(heading, FixedHeading):
        coefficients[0] = heading.at(a)[0]
        return coefficients, 0.0
    s = np.linspace(0.0, 1.0, 2 * _SAMPLES + 1)
    yaws = np.array([heading.at(a + x * T)[0] for x in s])
    # the ends are met, so that pieces join
    line = yaws[0] + s * (yaws[-1] - yaws[0])
    basis = (s * (1 - s))[:, None] * s[:, None] ** np.arange(_SIZE - 2)
    weights = np.linalg.lstsq(basis, yaws - line, rcond=None)[0]
    off = float(np.abs(basis @ weights + line - yaws).max())
    coefficients[:2] = yaws[0], yaws[-1] - yaws[0]
    # s (1 - s) s^k = s^(k+1) - s^(k+2)
    coefficients[1:-1] += weights
    coefficients[2:] -= weights
    return coefficients / T ** np.arange(_SIZE), off


def _shifted(coefficients: Array, time: float) -> Array:
    """Return the coefficients about a later time, padded to degree 7, shape (axes, 8)."""
    padded = np.zeros((len(coefficients), _SIZE))
    padded[:, : coefficients.shape[1]] = coefficients
    # Horner's scheme, repeated, divides by (t - time) again and again
    for first in range(_SIZE - 1):
        for k in range(_SIZE - 2, first - 1, -1):
            padded[:, k] += time * padded[:, k + 1]
    return padded


def _errors(trajectory: Trajectory, rows: NDArray) -> tuple[float, float]:
    """Return how far pieces are from a trajectory at most: position (m) and yaw (rad)."""
    exact = np.asarray(rows, dtype=float)
    flown = Polynomial(exact[:, -1], exact[:, :-1].reshape(-1, 4, _SIZE))
    times = np.linspace(0.0, trajectory.duration, max(200, _SAMPLES * len(flown)) + 1)
    values = flown.position(times)
    position = np.linalg.norm(values[:, :3] - trajectory.curve.position(times), axis=1).max()
    yaws = np.array([trajectory.heading.at(time)[0] for time in times])
    return float(position), float(np.abs(values[:, 3] - yaws).max())


def _quintic() -> Array:
    """Return what makes coefficients of degree 5 over [0, 1] from position, velocity, acceleration at 0 and at 1."""
    k = np.arange(6)
    at_1 = [np.ones(6), k, k * (k - 1)]
    return np.linalg.inv(np.array([*np.diag([1.0, 1.0, 2.0, 0, 0, 0])[:3], *at_1]))


_QUINTIC = _quintic()
# s^3 (1 - s)^3 and s times that: they change neither position, velocity nor acceleration of the ends
_BUMPS = np.array([[0, 0], [0, 0], [0, 0], [1, 0], [-3, 1], [3, -3], [-1, 3], [0, -1]], dtype=float)
