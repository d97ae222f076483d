"""A log of any format as a `RecordedFlight`: on one regular clock, in known units, checked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.column_map import Found, find
from crazychoir_fw.comparison.log_files import read_log
from crazychoir_fw.comparison.nanobench import COLUMNS, RecordedFlight, flight_of
from crazychoir_fw.comparison.raw_log import Array

_BRIDGED = 0.3  # [s], longer holes end a flight
_SHORTEST = 2.0  # [s]
_ESTIMATES = ("stateestimate", "estimate")


def load_flight(path: str | Path, columns: str | Path | None = None, drone: str | None = None) -> RecordedFlight:
    """Return the flight of a log.

    Args:
        path: The log, see `log_files.FORMATS`.
        columns: Preset or YAML file that says which columns are what; None takes the preset that knows most of them.
        drone: Whose columns, where a log has several drones.

    Raises:
        UnknownNameError: If there is no such file or preset.
        RangeError: If it is no log of a flight; one sentence that names file and column.
        MissingLibraryError: If a library for its format is not installed.
    """
    path = Path(path)
    raw = read_log(path, drone)
    found = find(raw, columns)
    names: dict[str, str] = {}
    try:
        flight = flight_of(_on_one_clock(path, found, names), path, list(raw.notes))
    except RangeError as error:
        raise RangeError(_translated(str(error), names)) from None
    position = found["position"].names[0]
    if not position.lower().startswith(_ESTIMATES):
        return flight
    note = f"no true position in the log: the estimate ({position}, …) is compared with the simulated estimate"
    return replace(flight, is_estimate=True, notes=(note, *flight.notes))


def _on_one_clock(path: Path, found: dict[str, Found], names: dict[str, str]) -> dict[str, Array]:
    """Return the columns as `nanobench` calls them, at the times of the positions; `names` learns how the log does."""
    clock = found["time"].values[0]
    begin, end = _overlap(path, found, clock)
    rows = ~np.isfinite(clock) | ((clock >= begin) & (clock <= end))  # what has no time is left out later
    names["column t"] = f"column {found['time'].names[0]}"
    table = {"t": clock[rows]}
    for quantity, one in found.items():
        if quantity.startswith("time"):
            continue
        values = one.values
        if quantity == "attitude" and len(values) == 3:
            roll, pitch, yaw = (np.radians(angle) for angle in values)
            values = tuple(quaternion_xyzw(np.stack([roll, -pitch, yaw], axis=-1)).T)
        if quantity == "setpoint_yaw":
            values = (np.degrees(np.unwrap(np.radians(values[0]))),)
        other = found.get(f"time of {quantity}")
        own = COLUMNS[quantity]
        for k, (name, column) in enumerate(zip(own, values, strict=True)):
            names[name] = one.names[min(k, len(one.names) - 1)]
            if other is not None:
                table[name] = _resampled(table["t"], other.values[0], column, quantity == "voltage")
            elif quantity == "voltage":
                table[name] = _bridged(table["t"], column[rows])
            else:
                table[name] = column[rows]
    return table


def _overlap(path: Path, found: dict[str, Found], clock: Array) -> tuple[float, float]:
    """Return from when to when all streams are there."""
    clocks = {"position": clock}
    clocks |= {name.removeprefix("time of "): one.values[0] for name, one in found.items() if name.startswith("time ")}
    spans = {}
    for name, times in clocks.items():
        finite = times[np.isfinite(times)]
        if len(finite) < 2:
            raise RangeError(f"{path.name}: the clock of {name} holds no numbers")
        spans[name] = (float(finite.min()), float(finite.max()))
    late, early = max(spans, key=lambda one: spans[one][0]), min(spans, key=lambda one: spans[one][1])
    begin, end = spans[late][0], spans[early][1]
    if end - begin < _SHORTEST:
        unit = found["time"].names[0]
        raise RangeError(
            f"{path.name}: {late} begins {end - begin:.3g} s before {early} ends, a flight has {_SHORTEST:g} s; "
            f"is the unit of {unit} right?"
        )
    return begin, end


def _resampled(times: Array, clock: Array, values: Array, is_sparse: bool) -> Array:
    """Return a stream on another clock; NaN in its holes, unless it is a slow one anyway."""
    known = np.isfinite(clock) & np.isfinite(values)
    if known.sum() < 2:
        return np.full(len(times), np.nan)
    order = np.argsort(clock[known], kind="stable")
    at, what = clock[known][order], values[known][order]
    result = np.interp(times, at, what)
    if not is_sparse:
        after = np.clip(np.searchsorted(at, times), 1, len(at) - 1)
        result[at[after] - at[after - 1] > _BRIDGED] = np.nan
    return result


def _bridged(times: Array, values: Array) -> Array:
    known = np.isfinite(values) & np.isfinite(times)
    return np.interp(times, times[known], values[known]) if known.sum() > 1 else values


def _translated(sentence: str, names: dict[str, str]) -> str:
    """Return a sentence with the columns as the log calls them."""
    for ours in sorted(names, key=len, reverse=True):
        sentence = sentence.replace(f" {ours} ", f" {names[ours]} ")
    return sentence
