"""Drawn curves: files of points, thinned, and turned into trajectories.

A file has one sample per line: ``x, y, t`` or ``x, y, z, t`` (m, s), or, under a heading that names them, any order of
those columns; without a time, points are flown through as fast as limits allow. What the original draws is relative to
its first point, so that it begins with ``0, 0, 0`` (docs/reference/crazychoir.md#15.1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.planning.allocation import allocate_times, trapezoidal_times
from crazychoir_fw.planning.curves import Polynomial, cubic_spline, minimum_snap
from crazychoir_fw.planning.curves.waypoints import checked_points
from crazychoir_fw.planning.limits import GENTLE, LimitReport, Limits, fit_duration

Array = NDArray[np.float64]

DISTANCE = 0.2
"""How far samples are apart that are kept (m), as in the original."""

LARGEST_FILE = 10_000_000  # bytes
_COLUMNS = {2: ("x", "y"), 3: ("x", "y", "t"), 4: ("x", "y", "z", "t")}
_NAMES = {"x": "x", "y": "y", "z": "z", "t": "t", "time": "t"}
_METHODS = {"spline": cubic_spline, "minimum_snap": minimum_snap}


@dataclass(frozen=True)
class Drawn:
    """Samples of a drawing."""

    points: Array
    """Positions (m), shape (m, 3)."""
    times: Array | None = None
    """When each was drawn (s), not decreasing, shape (m,); None if unknown."""

    def trajectory_points(self, *, time_scale: float = 1.0) -> list[TrajectoryPoint]:
        """Return the samples as a message for a `TrajectoryHandler`, with times from the first sample on."""
        if self.times is None:
            raise RangeError("Drawn: samples without times cannot be sent; fit_drawn finds times")
        times = (self.times - self.times[0]) * time_scale
        return [TrajectoryPoint(float(t), point) for t, point in zip(times, self.points, strict=True)]


@dataclass(frozen=True)
class DrawnFit:
    """A drawing made into something that flies."""

    curve: Polynomial
    """The curve."""
    report: LimitReport
    """What it asks for of the limits; says which one binds."""
    slowdown: float
    """How many times as slowly it is flown as the (scaled) times say."""
    deviation: float
    """How far the farthest sample lies beside the curve (m)."""


def read_drawn(path: Path | str, *, height: float = 1.0) -> Drawn:
    """Read a file of samples.

    Args:
        path: The file.
        height: z where the file has none (m).

    Raises:
        RangeError: If it is no such file; the text names file, line and what is wrong.
    """
    try:
        text = Path(path).read_bytes()[:LARGEST_FILE].decode()
    except OSError as error:
        raise RangeError(f"{path} cannot be read: {error.strerror}") from None
    except ValueError:
        raise RangeError(f"{str(path)!r} is not a text file") from None

    columns: tuple[str, ...] | None = None
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        cells = [cell.strip() for cell in line.rstrip().rstrip(",").split(",")]
        if not line.strip() or line.startswith("#"):
            continue
        where = f"{path}, line {number}"
        if columns is None:
            columns, is_heading = _columns(cells, where)
            if is_heading:
                continue
        rows.append(_sample(cells, columns, where))
        if "t" in columns and len(rows) > 1:
            time, before = (row[columns.index("t")] for row in (rows[-1], rows[-2]))
            if time < before:
                raise RangeError(f"{where}: t is {time:g}, but must not be less than {before:g}, which came before")
    if len(rows) < 2:
        raise RangeError(f"{path} has {len(rows)} points, allowed: at least 2")
    by_name = dict(zip(columns, np.array(rows).T, strict=True))
    z = by_name.get("z", np.full(len(rows), height))
    return Drawn(np.stack([by_name["x"], by_name["y"], z], axis=1), by_name.get("t"))


def thinned(drawn: Drawn, distance: float = DISTANCE) -> Drawn:
    """Return fewer samples: a sample is kept if the next one is farther than *distance* (m) from the last one kept.

    First and last sample are always kept; one between them that is nearer than half the distance to the last is not.
    """
    if not 0.0 <= distance < math.inf:
        raise RangeError(f"thinned: distance is {distance}, allowed: 0 m or more")
    points = checked_points("thinned", drawn.points)
    kept = [0]
    for k in range(1, len(points) - 1):
        if np.linalg.norm(points[k + 1] - points[kept[-1]]) > distance:
            kept.append(k)
    last = len(points) - 1
    if len(kept) > 1 and np.linalg.norm(points[last] - points[kept[-1]]) < distance / 2:
        kept.pop()
    kept.append(last)
    return Drawn(points[kept], None if drawn.times is None else np.asarray(drawn.times, dtype=float)[kept])


def fit_drawn(
    points: ArrayLike | Drawn,
    times: ArrayLike | None = None,
    *,
    distance: float = DISTANCE,
    time_scale: float = 1.0,
    origin: ArrayLike | None = None,
    limits: Limits | None = GENTLE,
    method: str = "spline",
    steadiness: float | None = None,
) -> DrawnFit:
    """Return a curve through what was drawn, from rest to rest.

    Args:
        points: Samples (m), shape (m, 3), or what `read_drawn` returned.
        times: When each was drawn (s), shape (m,); None flies as fast as limits allow, with minimum snap by
            `allocate_times`, with splines by stretching what stopping at each sample that is kept would take.
        distance: How far samples are apart that are kept (m).
        time_scale: What times are multiplied by; above 1 is slower.
        origin: Where the samples' (0, 0, 0) lies in the world (m), for drawings relative to their first point.
        limits: Given times are stretched until these hold; None flies as drawn.
        method: "spline" or "minimum_snap".
        steadiness: Speeds between samples that are kept stay within this factor of their mean, and of its inverse;
            None keeps the times. A hand, and a browser that tells of its moves in bursts, stop and jump, around which a
            curve would swing.

    Raises:
        RangeError: If the samples make no curve.
    """
    if method not in _METHODS:
        raise RangeError(f"fit_drawn: method is {method!r}, allowed: {', '.join(_METHODS)}")
    if not 0.0 < time_scale < math.inf:
        raise RangeError(f"fit_drawn: time_scale is {time_scale}, allowed: above 0")
    drawn = points if isinstance(points, Drawn) else Drawn(checked_points("fit_drawn", points), times)
    if drawn.points.shape[1] != 3:
        raise RangeError(f"fit_drawn: points have shape {drawn.points.shape}, allowed: (m, 3)")
    if origin is not None:
        drawn = Drawn(drawn.points + np.asarray(origin, dtype=float), drawn.times)
    few = thinned(drawn, distance)
    is_timed = few.times is not None
    if is_timed:
        times = few.times if steadiness is None else _steadied(few.points, few.times, steadiness)
        knots = (times - times[0]) * time_scale
    elif method == "minimum_snap":
        knots = allocate_times(few.points, limits or GENTLE).times
    else:
        knots = trapezoidal_times(few.points, limits or GENTLE)
    curve = _METHODS[method](knots, few.points)
    curve, slowdown, report = fit_duration(
        curve.stretched, limits or Limits(), may_shrink=not is_timed and bool(limits)
    )
    return DrawnFit(curve, report, slowdown, _deviation(curve, drawn.points))


def _steadied(points: Array, times: Array, steadiness: float) -> Array:
    """Return times between which the speed varies less; the whole takes as long."""
    if not 1.0 <= steadiness < math.inf:
        raise RangeError(f"fit_drawn: steadiness is {steadiness}, allowed: 1 or more")
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    total = float(times[-1] - times[0])
    if not (lengths.sum() > 0.0 and total > 0.0):
        return times
    usual = lengths * total / lengths.sum()
    durations = np.clip(np.diff(times), usual / steadiness, usual * steadiness)
    return np.concatenate([[0.0], np.cumsum(durations)]) * (total / durations.sum())


def _columns(cells: list[str], where: str) -> tuple[tuple[str, ...], bool]:
    """Return the names of the columns, and whether this line is a heading."""
    try:
        [float(cell) for cell in cells]
    except ValueError:
        names = tuple(_NAMES.get(cell.lower(), cell) for cell in cells)
        if not {"x", "y"} <= set(names) <= set(_NAMES.values()) or len(set(names)) != len(names):
            raise RangeError(f"{where}: the columns are {', '.join(cells)[:60]!r}, allowed: x, y, z, t") from None
        return names, True
    if len(cells) not in _COLUMNS:
        raise RangeError(f"{where} has {len(cells)} columns, allowed: x, y or x, y, t or x, y, z, t")
    return _COLUMNS[len(cells)], False


def _sample(cells: list[str], columns: tuple[str, ...], where: str) -> list[float]:
    if len(cells) != len(columns):
        raise RangeError(f"{where} has {len(cells)} columns, but must have {len(columns)}: {', '.join(columns)}")
    values = []
    for name, cell in zip(columns, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise RangeError(f"{where}: {name} is {cell[:40]!r}, but must be a finite number")
        values.append(value)
    return values


def _deviation(curve: Polynomial, points: Array) -> float:
    path = curve.position(np.linspace(0.0, curve.duration, 20 * len(curve) + 1))
    # to the pieces of a chain of chords
    begins, chords = path[:-1], np.diff(path, axis=0)
    lengths = np.maximum((chords**2).sum(axis=1), 1e-18)
    farthest = 0.0
    for point in points:
        along = np.clip(((point - begins) * chords).sum(axis=1) / lengths, 0.0, 1.0)
        farthest = max(farthest, float(np.linalg.norm(begins + along[:, None] * chords - point, axis=1).min()))
    return farthest
