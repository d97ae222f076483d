"""Pieces of a trajectory as the memory of a Crazyflie holds them, with the names of `cflib.crazyflie.mem`.

A `Poly4D` has 8 coefficients per axis and takes 132 bytes. The compressed form has Bézier control points in 16 bits:
a start, then segments whose axes are constant (no number), linear (the end point), cubic (3 control points) or of
degree 7 (7 control points); the first control point of a segment is the end of the one before
(docs/reference/planner-commander.md#4.1 and #5.1). Positions are meters, yaw radians, durations seconds.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError

_COEFFICIENTS = 8
_STORAGE_TYPES = {0: 0, 1: 1, 3: 2, 7: 3}  # by number of stored control points
_END_MARKER = bytes(3)  # a segment of duration 0


class Poly4D:
    """One piece of an uncompressed trajectory: x, y, z and yaw as polynomials of degree 7."""

    class Poly:
        """Coefficients of one axis in ascending powers of time."""

        def __init__(self, values: Sequence[float] = (0.0,) * _COEFFICIENTS) -> None:
            self.values = list(values)

    def __init__(
        self,
        duration: float,
        x: Poly | None = None,
        y: Poly | None = None,
        z: Poly | None = None,
        yaw: Poly | None = None,
    ) -> None:
        self.duration = duration
        self.x = x or self.Poly()
        self.y = y or self.Poly()
        self.z = z or self.Poly()
        self.yaw = yaw or self.Poly()

    def __repr__(self) -> str:
        return f"<Poly4D of {self.duration:g} s>"

    def pack(self) -> bytes:
        """Return the 132 bytes of the trajectory memory."""
        axes = [self.x.values, self.y.values, self.z.values, self.yaw.values]
        lengths = [len(values) for values in axes]
        if set(lengths) != {_COEFFICIENTS}:
            raise RangeError(f"{self!r} has {lengths} coefficients of x, y, z and yaw, allowed: 8")
        return np.array([*np.ravel(axes), self.duration], dtype="<f4").tobytes()


class CompressedStart:
    """Where a compressed trajectory starts: position (m) and yaw (rad)."""

    def __init__(self, x: float, y: float, z: float, yaw: float) -> None:
        self.x = x
        self.y = y
        self.z = z
        self.yaw = yaw

    def __repr__(self) -> str:
        return f"<CompressedStart at {self.x:g}, {self.y:g}, {self.z:g} m, yaw {self.yaw:g} rad>"

    def pack(self) -> bytes:
        """Return the 8 bytes of the start record; numbers are truncated to 1 mm and 0.1 deg."""
        return _pack_meters([self.x, self.y, self.z], self) + _pack_radians([self.yaw], self)


class CompressedSegment:
    """One segment: its duration (s) and the stored control points of each axis: none, 1, 3 or 7."""

    def __init__(
        self,
        duration: float,
        element_x: Sequence[float],
        element_y: Sequence[float],
        element_z: Sequence[float],
        element_yaw: Sequence[float],
    ) -> None:
        self.duration = duration
        self.x = list(element_x)
        self.y = list(element_y)
        self.z = list(element_z)
        self.yaw = list(element_yaw)
        lengths = [len(element) for element in (self.x, self.y, self.z, self.yaw)]
        if not set(lengths) <= set(_STORAGE_TYPES):
            raise RangeError(f"{self!r} has {lengths} control points of x, y, z and yaw, allowed: 0, 1, 3 or 7")

    def __repr__(self) -> str:
        return f"<CompressedSegment of {self.duration:g} s>"

    def pack(self) -> bytes:
        """Return the 3 to 59 bytes of the trajectory memory; numbers are truncated to 1 mm, 0.1 deg and 1 ms."""
        types = 0
        for axis, element in enumerate((self.x, self.y, self.z, self.yaw)):
            types |= _STORAGE_TYPES[len(element)] << 2 * axis
        milliseconds = _truncated([self.duration], 1000.0, self)[0]
        if not 0 < milliseconds <= 0xFFFF:
            raise RangeError(f"{self!r}: a segment takes 0.001 to 65.535 s")
        points = _pack_meters([*self.x, *self.y, *self.z], self) + _pack_radians(self.yaw, self)
        return struct.pack("<BH", types, milliseconds) + points


def pack_compressed(start: CompressedStart, segments: Iterable[CompressedSegment]) -> bytes:
    """Return a whole compressed trajectory with the end marker that cflib leaves out.

    Without it the drone would go on with whatever an earlier, longer upload left behind.
    """
    return start.pack() + b"".join(segment.pack() for segment in segments) + _END_MARKER


def compress(pieces: ArrayLike, tolerance: float = 0.001) -> tuple[CompressedStart, list[CompressedSegment]]:
    """Turn polynomial pieces into a compressed trajectory, each axis in its shortest form that is near enough.

    A polynomial of degree 7 over [0, T] has the Bézier control points b_j = sum_k C(j, k) / C(7, k) a_k T^k. Two curves
    are never farther apart than their control points, written in the same degree.

    Args:
        pieces: Shape (n, 33): 8 ascending coefficients of x, y, z (m) and yaw (rad), then the duration (s). Each piece
            starts where the one before ends.
        tolerance: What a shorter form may be off (m, rad). Rounding to 1 mm, 0.1 deg and 1 ms comes on top.

    Raises:
        RangeError: If the pieces have another shape, or do not join.
    """
    rows = np.asarray(pieces, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != 4 * _COEFFICIENTS + 1 or not len(rows) or not np.all(np.isfinite(rows)):
        raise RangeError(f"pieces have shape {rows.shape}, allowed: (n, 33) finite numbers")

    durations = rows[:, -1]
    powers = durations[:, None] ** np.arange(_COEFFICIENTS)
    # control points, shape (n, 4, 8)
    points = (rows[:, :-1].reshape(-1, 4, _COEFFICIENTS) * powers[:, None, :]) @ _BEZIER.T
    gaps = np.abs(points[1:, :, 0] - points[:-1, :, -1])
    if np.any(gaps > tolerance):
        raise RangeError(f"piece {gaps.max(axis=1).argmax() + 1} starts {gaps.max():g} m or rad beside the one before")

    start = CompressedStart(*(_between(value, step) for value, step in zip(points[0, :, 0], _STEPS, strict=True)))
    segments = []
    for duration, axes in zip(durations, points, strict=True):
        stored = [_shortest(curve, tolerance) for curve in axes]
        elements = [[_between(v, step) for v in values] for values, step in zip(stored, _STEPS, strict=True)]
        segments.append(CompressedSegment(_between(duration, 0.001), *elements))
    return start, segments


def decompress(start: CompressedStart, segments: Iterable[CompressedSegment]) -> NDArray[np.float64]:
    """Return the polynomial pieces that a drone makes of a compressed trajectory, shape (n, 33).

    Numbers are truncated as they are when they are packed.
    """
    ends = [_truncated([value], 1.0 / step, start)[0] * step for value, step in zip(_start(start), _STEPS, strict=True)]
    rows = []
    for segment in segments:
        duration = _truncated([segment.duration], 1000.0, segment)[0] / 1000.0
        row = np.zeros((4, _COEFFICIENTS))
        for axis, (stored, step) in enumerate(zip((segment.x, segment.y, segment.z, segment.yaw), _STEPS, strict=True)):
            points = [ends[axis], *(number * step for number in _truncated(stored, 1.0 / step, segment))]
            row[axis] = np.linalg.solve(_BEZIER, _elevation(len(points) - 1) @ points)
            ends[axis] = points[-1]
        rows.append([*(row / duration ** np.arange(_COEFFICIENTS)).ravel(), duration])
    return np.array(rows)


def _start(start: CompressedStart) -> tuple[float, float, float, float]:
    return start.x, start.y, start.z, start.yaw


# control points of degree 7 from coefficients over [0, 1]
_BEZIER = np.array([[math.comb(j, k) / math.comb(7, k) for k in range(8)] for j in range(8)])
_STEPS = (0.001, 0.001, 0.001, math.pi / 1800)


def _elevation(degree: int) -> NDArray[np.float64]:
    """Return the matrix that writes control points of a lower degree in degree 7, shape (8, degree + 1)."""
    weights = [
        [
            math.comb(degree, i) * math.comb(7 - degree, j - i) / math.comb(7, j) if 0 <= j - i <= 7 - degree else 0.0
            for i in range(degree + 1)
        ]
        for j in range(8)
    ]
    return np.array(weights)


def _shortest(curve: NDArray[np.float64], tolerance: float) -> list[float]:
    """Return the stored control points of the shortest form of *curve*, which has the 8 of degree 7."""
    first, second, *_, last_but_one, last = curve
    cubic = [first, first + (second - first) * 7 / 3, last - (last - last_but_one) * 7 / 3, last]
    for candidate in ([first], [first, last], cubic):
        off = _elevation(len(candidate) - 1) @ candidate - curve
        if np.abs(off).max() <= tolerance:
            return candidate[1:]
    return list(curve[1:])


def _between(value: float, step: float) -> float:
    """Return *value* rounded to a whole number of steps, and a bit on, so that truncation finds that number."""
    steps = round(value / step)
    return (steps + math.copysign(0.1, steps)) * step


def _truncated(values: Sequence[float], steps: float, what: object) -> list[int]:
    """Return *values* as whole numbers of steps, truncated toward zero as cflib does."""
    if not all(math.isfinite(value) for value in values):
        raise RangeError(f"{what!r} holds {[float(v) for v in values]}, allowed: finite numbers")
    return [int(value * steps) for value in values]


def _pack_meters(values: Sequence[float], what: object) -> bytes:
    return _pack_int16(_truncated(values, 1000.0, what), what, "32.767 m")


def _pack_radians(values: Sequence[float], what: object) -> bytes:
    degrees = [math.degrees(value) for value in values]
    return _pack_int16(_truncated(degrees, 10.0, what), what, "3276.7 deg")


def _pack_int16(numbers: Sequence[int], what: object, limit: str) -> bytes:
    if any(abs(number) > 32767 for number in numbers):
        raise RangeError(f"{what!r} holds {list(numbers)} steps, allowed: -{limit} to {limit}")
    return struct.pack(f"<{len(numbers)}h", *numbers)
