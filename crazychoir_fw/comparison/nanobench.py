"""Reads flights in the format of the NanoBench data set (arXiv 2603.09908) and repairs their known defects.

What is handled here, so that nothing above needs to know of it:

- headers that promise degrees where the values are radians: columns ``roll``, ``pitch``, ``yaw`` are not used at all,
  the quaternion is;
- ``sp_ctrltarget_yaw``, which is a yaw rate: the desired yaw is ``pid_controller_yaw``;
- desired attitudes that are all zero, which tell a flight of another controller than PID;
- spans behind which columns run away (shifted or extrapolated): a flight ends before its first impossible row;
- empty cells and NaN: short holes are bridged, long ones end the flight;
- repeated or descending time stamps, which are left out.
"""

from __future__ import annotations

import csv
import gzip
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import yaml
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.comparison.csv_log import limited, number

PERIOD = 0.01
"""Time (s) between two rows of a flight after reading."""

_SUFFIXES = (".csv", ".csv.gz")
_SHORTEST = 2.0  # [s], less is no flight
_HOLE = 0.3  # [s], longer holes are not bridged
_MARGIN = 0.1  # [s], cut off before an impossible row

_POSITION = ("px", "py", "pz")
_QUATERNION = ("qx", "qy", "qz", "qw")
_MOTORS = tuple(f"motor_motor_m{i}" for i in (1, 2, 3, 4))
_VOLTAGE = ("pwr_pm_vbat",)
_SETPOINT = tuple(f"sp_ctrltarget_{axis}" for axis in "xyz")
_ESTIMATE = tuple(f"est_stateEstimate_{name}" for name in ("x", "y", "z", "vx", "vy", "vz"))
_ATTITUDE = tuple(f"att_stateEstimate_{name}" for name in ("roll", "pitch", "yaw"))
_GYRO = tuple(f"imu_gyro_{axis}" for axis in "xyz")
_DESIRED = ("pid_controller_roll", "pid_controller_pitch", "pid_controller_yaw", "pid_controller_cmd_thrust")

_YAW = ("sp_yaw",)

COLUMNS = {
    "position": _POSITION,
    "attitude": _QUATERNION,
    "setpoint": _SETPOINT,
    "setpoint_yaw": _YAW,
    "motors": _MOTORS,
    "voltage": _VOLTAGE,
    "estimate_position": _ESTIMATE[:3],
    "estimate_velocity": _ESTIMATE[3:],
    "estimate_attitude": _ATTITUDE,
    "gyro": _GYRO,
    "desired_attitude": _DESIRED[:3],
    "thrust_command": _DESIRED[3:],
}
"""Columns of each quantity (`column_map`)."""

REQUIRED = ("t", *_POSITION, *_QUATERNION)
"""Columns without which nothing can be compared."""

# lowest and highest value that a row of a real flight can have
_POSSIBLE: dict[tuple[str, ...], tuple[float, float]] = {
    _POSITION: (-30.0, 30.0),
    _QUATERNION: (-1.001, 1.001),
    _MOTORS: (-1.0, 65536.0),
    _VOLTAGE: (2.0, 5.0),
    _SETPOINT: (-30.0, 30.0),
    _YAW: (-100_000.0, 100_000.0),
    _ESTIMATE: (-30.0, 30.0),
    _ATTITUDE: (-360.0, 360.0),
    _GYRO: (-40.0, 40.0),
    _DESIRED: (-400.0, 70000.0),
}
_FARTHEST_ESTIMATE = 1.0  # [m] from the truth; farther away the columns belong to different flights


Recorded: TypeAlias = Any
"""An array of float64, or None if it was not recorded; `RecordedFlight.missing` says so in a sentence."""


@dataclass(frozen=True)
class RecordedFlight:
    """One flight on a regular clock of 100 Hz that starts at 0. What was not recorded is None."""

    name: str
    """Name of the file without suffix."""
    time: NDArray[np.float64]
    """Clock of the motion capture (s), shape (T,), steps of `PERIOD`."""
    position: NDArray[np.float64]
    """True position (m, world), shape (T, 3); that of the onboard estimator if `is_estimate`."""
    quat_xyzw: NDArray[np.float64]
    """True attitude of the marker frame, body to world, unit and without flips of sign, shape (T, 4)."""
    is_estimate: bool = False
    """Whether position and attitude are those of the onboard estimator, because the log has no true ones."""
    motors: Recorded = None
    """Ratios of the four motors, 0 to 65535, shape (T, 4)."""
    voltage: Recorded = None
    """Voltage of the pack (V), shape (T,)."""
    setpoint: Recorded = None
    """Position that the onboard software was to hold (m, world), shape (T, 3)."""
    setpoint_yaw: Recorded = None
    """Yaw that it was to hold (deg), shape (T,)."""
    estimate: Recorded = None
    """Position and velocity of the onboard estimator (m, m/s, world), shape (T, 6)."""
    attitude: Recorded = None
    """Roll, pitch, yaw of the onboard estimator (deg, the firmware's sign of pitch), shape (T, 3)."""
    gyro: Recorded = None
    """Body rates (rad/s) as the radio brought them, shape (T, 3)."""
    desired: Recorded = None
    """Desired roll, pitch, yaw (deg) and thrust (counts) of the PID cascade, shape (T, 4); None for others."""
    filled: dict[str, NDArray[np.bool_]] = field(default_factory=dict)
    """For each group of columns the rows that were not logged but interpolated, shape (T,)."""
    metadata: dict[str, Any] = field(default_factory=dict)
    """What the YAML file beside it says."""
    notes: tuple[str, ...] = ()
    """Defects of the log and their repairs, as sentences."""

    @property
    def controller(self) -> str:
        """``pid`` or ``mellinger``."""
        return "pid" if self.desired is not None else "mellinger"

    def missing(self, *groups: str) -> str | None:
        """Return a sentence about groups of columns that are not there, or None if all are."""
        absent = [group for group in groups if getattr(self, group) is None]
        return f"{self.name}: {', '.join(absent)} not recorded" if absent else None


def flight_files(folder: str | Path, names: Sequence[str] = ()) -> list[Path]:
    """Return the flights of a folder and its subfolders, sorted by name.

    Args:
        folder: The folder.
        names: Only flights of these names (without suffix); all by default.

    Raises:
        UnknownNameError: If there is no such folder, no flight in it, or none of one of the names.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise UnknownNameError(f"no folder '{folder}'")
    found = {
        _name(path): path for path in sorted(folder.rglob("*")) if path.name.endswith(_SUFFIXES) and path.is_file()
    }
    if not found:
        raise UnknownNameError(f"no flights (*.csv, *.csv.gz) in '{folder}'")
    for name in names:
        if name not in found:
            raise UnknownNameError(f"no flight '{name}' in '{folder}', there are: {', '.join(found)}")
    return [found[name] for name in (names or found)]


def read_flight(path: str | Path) -> RecordedFlight:
    """Read one flight.

    Args:
        path: A ``.csv`` or ``.csv.gz`` file; a ``.yaml`` of the same name beside it is read too.

    Raises:
        UnknownNameError: If there is no such file.
        RangeError: If it is no flight; the message names the file and what is wrong.
    """
    path = Path(path)
    if not path.is_file():
        raise UnknownNameError(f"no file '{path}'")
    return flight_of(_read_columns(path), path, [])


def flight_of(columns: dict[str, NDArray[np.float64]], path: Path, notes: list[str]) -> RecordedFlight:
    """Return a flight of columns that are called as those of the set, whatever file they come from.

    Args:
        columns: Values by name, (T,) each.
        path: The file, for messages.
        notes: What was found wrong so far.

    Raises:
        RangeError: If it is no flight; the message names the file and what is wrong.
    """
    absent = [name for name in REQUIRED if name not in columns]
    if absent:
        raise RangeError(f"{path.name}: columns {', '.join(absent)} are missing, so that nothing can be compared")
    columns = _ascending(columns, path, notes)
    columns = _plausible(columns, path, notes)
    return _resample(columns, path, notes)


def _name(path: Path) -> str:
    return path.name.removesuffix(".gz").removesuffix(".csv")


def _read_columns(path: Path) -> dict[str, NDArray[np.float64]]:
    opener = gzip.open if path.suffix == ".gz" else open
    wanted = {"t", *(name for group in _POSSIBLE for name in group)}
    try:
        with opener(path, "rt", newline="", encoding="utf-8") as file:
            reader = csv.reader(limited(file))
            header = [name.strip() for name in next(reader, [])]
            places = [(name, header.index(name)) for name in dict.fromkeys(header) if name in wanted]
            rows = [[number(row, place) for _, place in places] for row in reader if row]
    except (OSError, EOFError, UnicodeDecodeError, csv.Error, zlib.error) as error:
        raise RangeError(f"{path.name}: cannot be read: {error}") from error
    if not places:
        raise RangeError(f"{path.name}: no column of a flight in its first line")
    if not rows:
        raise RangeError(f"{path.name}: no rows")
    table = np.array(rows, float)
    return {name: table[:, i] for i, (name, _) in enumerate(places)}


def _ascending(columns: dict[str, NDArray[Any]], path: Path, notes: list[str]) -> dict[str, NDArray[Any]]:
    time = columns["t"]
    latest = np.fmax.accumulate(np.where(np.isfinite(time), time, -np.inf))
    keep = np.isfinite(time) & (time > np.concatenate([[-np.inf], latest[:-1]]))
    if not keep.all():
        notes.append(f"{int((~keep).sum())} rows without an ascending time left out")
    if keep.sum() < 2:
        raise RangeError(f"{path.name}: no ascending time in column t")
    return {name: values[keep] for name, values in columns.items()}


def _plausible(columns: dict[str, NDArray[Any]], path: Path, notes: list[str]) -> dict[str, NDArray[Any]]:
    """Cut the flight before its first impossible row, and fill short holes."""
    time = columns["t"]
    good = np.ones(len(time), bool)
    reasons: list[tuple[int, str]] = []

    def demand(row_is_good: NDArray[np.bool_], reason: str) -> None:
        nonlocal good
        if not row_is_good.all():
            reasons.append((int(np.argmin(row_is_good)), reason))
            good &= row_is_good

    for group, (low, high) in _POSSIBLE.items():
        for name in group:
            if name in columns:
                values = columns[name]
                demand(~((values < low) | (values > high)), f"{name} leaves {low:g} to {high:g}")
    for name in list(columns):
        holes = ~np.isfinite(columns[name])
        if holes.all():
            if name in REQUIRED:
                raise RangeError(f"{path.name}: column {name} holds no numbers")
            notes.append(f"column {name} holds no numbers")
            del columns[name]
        elif holes.any():
            filled = np.interp(time, time[~holes], columns[name][~holes])
            demand(~(holes & _far_from(time, time[~holes], _HOLE)), f"{name} is not there for more than {_HOLE} s")
            columns[name] = filled
            notes.append(f"{int(holes.sum())} empty cells of {name} bridged")
    norm = np.sqrt(sum(columns[name] ** 2 for name in _QUATERNION))
    demand(np.abs(norm - 1.0) < 0.05, "the quaternion is no rotation")
    if all(name in columns for name in _ESTIMATE[:3]):
        distance = np.sqrt(sum((columns[a] - columns[b]) ** 2 for a, b in zip(_ESTIMATE[:3], _POSITION, strict=True)))
        demand(distance < _FARTHEST_ESTIMATE, f"estimate and truth are more than {_FARTHEST_ESTIMATE} m apart")
    gap = np.concatenate([[0.0], np.diff(time)]) < 10 * _HOLE
    demand(gap, "the clock jumps")

    if good.all():
        return columns
    row, reason = min(reasons)
    end = time[row] - time[0]
    notes.append(f"unusable from {end:.2f} s on: {reason}")
    keep = time - time[0] < end - _MARGIN
    if not keep.any():
        raise RangeError(f"{path.name}: unusable from its start: {reason}")
    return {name: values[keep] for name, values in columns.items()}


def _far_from(time: NDArray[Any], known: NDArray[Any], distance: float) -> NDArray[np.bool_]:
    after = np.searchsorted(known, time)
    left = time - known[np.clip(after - 1, 0, len(known) - 1)]
    right = known[np.clip(after, 0, len(known) - 1)] - time
    return np.abs(left) + np.abs(right) > distance


def _resample(columns: dict[str, NDArray[Any]], path: Path, notes: list[str]) -> RecordedFlight:
    start = columns["t"][0]
    recorded = columns["t"] - start
    if recorded[-1] < _SHORTEST:
        raise RangeError(f"{path.name}: only {recorded[-1]:.2f} s are usable, a flight has {_SHORTEST:g} s")
    time = np.arange(0.0, recorded[-1], PERIOD)

    def group(names: tuple[str, ...], optional: bool = True) -> NDArray[np.float64] | None:
        absent = [name for name in names if name not in columns]
        if absent and optional:
            if len(absent) < len(names):
                notes.append(f"{', '.join(absent)} not recorded")
            return None
        return np.stack([np.interp(time, recorded, columns[name]) for name in names], axis=1)

    position, quaternion = (np.asarray(group(names, optional=False)) for names in (_POSITION, _QUATERNION))
    desired = group(_DESIRED)
    if desired is not None and not np.any(np.abs(desired[:, [0, 1, 3]]) > 1e-6):
        notes.append("desired attitudes are zero: not flown by the PID controller")
        desired = None
    voltage, yaw = group(_VOLTAGE), group(_YAW)
    parts: dict[str, Any] = {
        "motors": group(_MOTORS),
        "setpoint": group(_SETPOINT),
        "estimate": group(_ESTIMATE),
        "attitude": group(_ATTITUDE),
        "gyro": group(_GYRO),
        "desired": desired,
    }
    return RecordedFlight(
        name=_name(path),
        time=time,
        position=position,
        quat_xyzw=_continuous(quaternion),
        voltage=None if voltage is None else voltage[:, 0],
        setpoint_yaw=None if yaw is None else yaw[:, 0],
        filled={name: interpolated_rows(values) for name, values in parts.items() if values is not None},
        metadata=_metadata(path, notes),
        notes=tuple(notes),
        **parts,
    )


def _continuous(quaternion: NDArray[Any]) -> NDArray[Any]:
    """Return unit quaternions whose sign does not flip from row to row."""
    unit = quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)
    signs = np.where(np.sum(unit[1:] * unit[:-1], axis=1) < 0.0, -1.0, 1.0)
    unit[1:] *= np.cumprod(signs)[:, None]
    return unit


def interpolated_rows(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which rows lie on straight lines through their neighbors in every column, shape (T,).

    Rows that the radio lost were filled that way; constant rows count as logged.
    """
    straight = np.zeros(len(values), bool)
    if len(values) < 3:
        return straight
    scale = np.maximum(np.ptp(values, axis=0), 1e-12)
    steps = np.diff(values, axis=0) / scale
    moving = np.abs(steps[1:]) > 1e-9
    bent = np.abs(np.diff(steps, axis=0)) > 1e-6
    straight[1:-1] = moving.any(axis=1) & ~bent.any(axis=1)
    return straight


def _metadata(path: Path, notes: list[str]) -> dict[str, Any]:
    file = path.with_name(f"{_name(path)}.yaml")
    if not file.is_file():
        return {}
    try:
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        content = None
    if not isinstance(content, dict):
        notes.append(f"{file.name} is no mapping")
        return {}
    return content
