"""Which columns of a log are what, in which unit: named presets, and YAML files of users.

    extends: crazyflie                      # a preset; without it, only what stands here
    time: {columns: [t_us], unit: us}
    position: {columns: [vicon_x, vicon_y, vicon_z], unit: mm}

Each quantity is one such entry, or a list of alternatives of which the first counts whose columns are all there.
Names are compared without case, and with ``.``, ``/``, ``_`` and spaces alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import MissionError, RangeError, UnknownNameError
from crazychoir_fw.common.plain_yaml import read_yaml
from crazychoir_fw.comparison.raw_log import Array, RawLog, alike

_FOLDER = Path(__file__).resolve().parent / "column_maps"
PRESETS = tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))
"""Maps that have a name; the one that knows most of a log is taken when none is named."""

_DEGREES = {"deg": 1.0, "rad": 57.29577951308232}
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "position": _LENGTHS,
    "attitude": _DEGREES,
    "setpoint": _LENGTHS,
    "setpoint_yaw": _DEGREES,
    "motors": {"counts": 1.0, "ratio": 65535.0, "percent": 655.35},
    "voltage": {"V": 1.0, "mV": 0.001},
    "estimate_position": _LENGTHS,
    "estimate_velocity": {"m/s": 1.0, "mm/s": 0.001},
    "estimate_attitude": _DEGREES,
    "gyro": {"rad/s": 1.0, "deg/s": 0.017453292519943295},
    "desired_attitude": _DEGREES,
    "thrust_command": {"counts": 1.0, "ratio": 65535.0, "percent": 655.35},
}
"""Quantities, with the units that a map may name; the first is the default, and that of `Found`."""

COUNTS = {"time": (1,), "attitude": (3, 4), "motors": (4,), "voltage": (1,), "setpoint_yaw": (1,)}
COUNTS |= {"thrust_command": (1,)}
"""How many columns a quantity has, where not three."""

REQUIRED = ("time", "position", "attitude")
"""Without these nothing can be compared."""


@dataclass(frozen=True)
class Entry:
    """One way in which a log may hold a quantity."""

    columns: tuple[str, ...]
    scale: float
    """From the unit of the log to that of `UNITS`."""


@dataclass(frozen=True)
class Found:
    """A quantity in a log."""

    table: int
    names: tuple[str, ...]
    """As the log calls them."""
    values: tuple[Array, ...]


ColumnMap = Mapping[str, tuple[Entry, ...]]


def load_map(chosen: str | Path) -> ColumnMap:
    """Return a map by the name of its preset or its file.

    Raises:
        UnknownNameError: If it is neither.
        RangeError: If it names a quantity, a unit or a number of columns that is not allowed.
    """
    if str(chosen) in PRESETS:
        return _read(_FOLDER / f"{chosen}.yaml")
    path = Path(chosen)
    if not path.is_file():
        raise UnknownNameError(f"--columns is {str(chosen)[:60]!r}, allowed: a YAML file or {', '.join(PRESETS)}")
    return _read(path)


def _read(path: Path) -> ColumnMap:
    try:
        data = read_yaml(path, MissionError)
    except MissionError as error:
        raise RangeError(str(error)) from None
    if not isinstance(data, Mapping):
        raise RangeError(f"{path}: must be a mapping of quantities such as time and position")
    given = dict(data)
    extended = given.pop("extends", None)
    if extended is not None and extended not in PRESETS:
        raise RangeError(f"{path}: extends is {str(extended)[:40]!r}, allowed: {', '.join(PRESETS)}")
    known = dict(load_map(extended)) if extended is not None else {}
    return known | {str(name): _entries(path, str(name), entry) for name, entry in given.items()}


def _entries(path: Path, name: str, given: Any) -> tuple[Entry, ...]:
    if name not in UNITS:
        raise RangeError(f"{path}: {name[:40]} is no quantity, allowed: {', '.join(UNITS)}")
    alternatives = given if isinstance(given, list) and given and isinstance(given[0], Mapping) else [given]
    return tuple(_entry(path, name, one) for one in alternatives)


def _entry(path: Path, name: str, given: Any) -> Entry:
    if not isinstance(given, Mapping):
        given = {"columns": given}
    unknown = sorted(set(map(str, given)) - {"columns", "unit"})
    if unknown:
        raise RangeError(f"{path}: {name}.{unknown[0][:40]} is not known, allowed: columns, unit")
    columns = given.get("columns")
    columns = [columns] if isinstance(columns, str) else columns
    counts = COUNTS.get(name, (3,))
    if not isinstance(columns, list) or len(columns) not in counts or not all(isinstance(c, str) for c in columns):
        raise RangeError(f"{path}: {name}.columns must be {' or '.join(map(str, counts))} names of columns")
    units = UNITS[name]
    unit = str(given.get("unit", next(iter(units))))
    if unit not in units:
        raise RangeError(f"{path}: {name}.unit is {unit[:20]!r}, allowed: {', '.join(units)}")
    return Entry(tuple(columns), units[unit])


def find(raw: RawLog, chosen: str | Path | None) -> dict[str, Found]:
    """Return the quantities of a log, in the first unit of `UNITS`; `time` is that of the table with the position.

    Args:
        raw: The log.
        chosen: Preset or file of a map; None takes the preset that knows most of it.

    Raises:
        UnknownNameError, RangeError: See `load_map`; or if the log lacks what is `REQUIRED`.
    """
    if chosen is not None:
        found = _apply(raw, load_map(chosen))
    else:
        found = max((_apply(raw, load_map(name)) for name in PRESETS), key=len)
    absent = [name for name in REQUIRED if name not in found]
    if absent:
        by = f"columns {chosen}" if chosen is not None else "any known names"
        raise RangeError(
            f"{raw.name}: no {', no '.join(absent)} by {by}; its columns are {raw.shown_columns()}: "
            "name them in a YAML file for --columns (docs/compare.md)"
        )
    return found


def clock_of(raw: RawLog, columns: ColumnMap, table: int) -> Found | None:
    """Return the clock of a table (s), or None if it has none."""
    return _first(raw, columns.get("time", ()), (table,))


def _apply(raw: RawLog, columns: ColumnMap) -> dict[str, Found]:
    tables = [k for k in range(len(raw.tables)) if clock_of(raw, columns, k) is not None]
    found = {name: _first(raw, entries, tables) for name, entries in columns.items() if name != "time"}
    known = {name: one for name, one in found.items() if one is not None}
    if tables and "position" not in known:
        any_clock = clock_of(raw, columns, tables[0])
        assert any_clock is not None
        known["time"] = any_clock
    if "position" in known:
        clock = clock_of(raw, columns, known["position"].table)
        assert clock is not None  # only tables with a clock are looked at
        known["time"] = clock
        for name, one in list(known.items()):
            if one.table != clock.table:
                other = clock_of(raw, columns, one.table)
                assert other is not None
                known[f"time of {name}"] = other
    return known


def _first(raw: RawLog, entries: tuple[Entry, ...], tables: list[int] | tuple[int, ...]) -> Found | None:
    for entry in entries:
        for k in tables:
            names = {alike(name): name for name in raw.tables[k]}
            if all(alike(column) in names for column in entry.columns):
                own = tuple(names[alike(column)] for column in entry.columns)
                return Found(k, own, tuple(entry.scale * raw.tables[k][name] for name in own))
    return None
