"""What was sampled of a flight, as a flight log: for files, and for browsers that download it."""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.signals import POSE_FIELDS, motion_signals

if TYPE_CHECKING:
    from crazychoir_fw.gui.branches import Sample
    from crazychoir_fw.gui.session import Session

FORMATS = {"csv": "text/csv", "mcap": "application/octet-stream", "npz": "application/octet-stream"}
"""Kinds of files, and what browsers call them."""
_ROWS_AT_A_TIME = 500  # samples of all drones
_BYTES_AT_A_TIME = 1 << 16


def check_format(name: str) -> str:
    """Return the format of a file name.

    Raises:
        RangeError: If it is none of `FORMATS`.
        CrazychoirError: If the library for it is not installed.
    """
    kind = Path(name).suffix.lstrip(".").lower()
    if kind not in FORMATS:
        raise RangeError(f"{name[:80]}: a log is allowed to be {', '.join('.' + word for word in FORMATS)}")
    if kind == "mcap":
        from crazychoir_fw.recording.mcap_file import require_mcap

        require_mcap()
    return kind


def record_of(session: Session, number: int | None = None) -> FlightLog:
    """Return what was sampled in a branch of a flight, and before it in those that it comes from.

    Poses are ``sim.*`` where the truth is known, and ``stateEstimate.*`` where drones told them; references are
    ``ctrltarget.x`` and so on. Log variables have samples for as long as some browser plotted them, else NaN.

    Args:
        session: The flight.
        number: Of the branch; None is the one that is flown.

    Raises:
        StateError: If there is no such branch, or nothing in it.
    """
    branches = session.branches
    number = branches.present.number if number is None else number
    times, samples = branches.lineage(number)
    if not times:
        raise StateError("nothing has been flown yet; there is nothing to log")
    group = "sim" if session.access.knows_truth else "stateEstimate"
    signals = _sampled(group, samples)
    _add_watched(signals, samples, len(session.names))
    mission = session.mission
    about = {
        "mission": mission.name,
        "description": mission.description,
        "backend": mission.backend,
        "seed": mission.seed,
        "platform": ", ".join(sorted({drone.platform for drone in mission.fleet})),
        "branch": number,
    }
    return FlightLog(np.array(times), session.names, signals, about, _events(session, number))


def _sampled(group: str, samples: Sequence[Sample]) -> dict[str, NDArray[Any]]:
    """Return the signals that every sample has, of shape (samples, drones) each."""
    poses = (np.array([getattr(sample, name) for sample in samples], float) for name in POSE_FIELDS)
    signals = motion_signals(group, *poses)
    if group == "stateEstimate":
        turned = np.array([sample.orientation for sample in samples])
        signals |= {f"stateEstimate.q{axis}": turned[..., k] for k, axis in enumerate("xyzw")}
    wanted = np.array([sample.reference for sample in samples])
    signals |= {f"ctrltarget.{axis}": wanted[..., k] for k, axis in enumerate("xyz")}
    return signals


def _add_watched(signals: dict[str, NDArray[Any]], samples: Sequence[Sample], drones: int) -> None:
    """Add the variables that were plotted; one of the name of a sampled signal does not replace it."""
    sampled = frozenset(signals)
    for row, sample in enumerate(samples):
        for (drone, name), value in (sample.watched or {}).items():
            if name in sampled:
                continue
            if name not in signals:
                signals[name] = np.full((len(samples), drones), np.nan)
            signals[name][row, drone] = value


def _events(session: Session, number: int) -> list[dict[str, Any]]:
    """Return the commands of a branch, and what happened in it if it is the one that is flown, by time."""
    branches = session.branches
    events = [
        {"time": mark["time"], "kind": "command", "drone": None, "details": {"text": mark["text"]}}
        for mark in branches.marks_of(number)
    ]
    if number == branches.present.number:
        events += [happening.as_dict() for happening in list(session.experiment.events)]
    events.sort(key=lambda event: event["time"])
    return events


def csv_lines(log: FlightLog) -> Iterator[str]:
    """Return a log as CSV, some rows at a time: time (s), drone, and all signals; what is not known is empty."""
    names = list(log.signals)
    columns = [log.signals[name] for name in names]
    yield ",".join(["time", "drone", *names]) + "\n"
    for begin in range(0, len(log.time), _ROWS_AT_A_TIME):
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        for k in range(begin, min(begin + _ROWS_AT_A_TIME, len(log.time))):
            for i, drone in enumerate(log.drone_ids):
                values = [column[k, i] for column in columns]
                rows.writerow([f"{log.time[k]:.4f}", drone, *("" if v != v else f"{v:.7g}" for v in values)])
        yield text.getvalue()


def write_record(log: FlightLog, path: Path) -> None:
    """Write a log as its suffix says; *path* is replaced in one step, or left alone if writing fails.

    Raises:
        RangeError: If the suffix is none of `FORMATS`.
        CrazychoirError: If the library for it is not installed.
    """
    _WRITERS[check_format(path.name)](log, path)


def _write_csv(log: FlightLog, path: Path) -> None:
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        file.writelines(csv_lines(log))


def _write_mcap(log: FlightLog, path: Path) -> None:
    from crazychoir_fw.recording.mcap_file import write_mcap

    write_mcap(log, path)


_WRITERS: dict[str, Callable[[FlightLog, Path], Any]] = {
    "csv": _write_csv,
    "mcap": _write_mcap,
    "npz": FlightLog.save,
}


def parts_of(log: FlightLog, kind: str) -> Iterator[bytes]:
    """Return a file of a format, some bytes at a time."""
    if kind == "csv":
        for text in csv_lines(log):
            yield text.encode()
        return
    with tempfile.TemporaryDirectory(prefix="crazychoir-") as folder:
        path = Path(folder) / f"flight.{kind}"
        write_record(log, path)
        with path.open("rb") as file:
            while part := file.read(_BYTES_AT_A_TIME):
                yield part
