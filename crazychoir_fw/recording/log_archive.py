"""Makes the log of a finished flight out of its stream, in memory that does not grow with the flight.

A stream has its samples row by row, a log signal by signal. Rows are read in groups, each signal of a group goes to its
place in a scratch file, and the signals are packed from there one after the other. The scratch file is as large as the
signals are, and lies beside the log.
"""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.recording.flight_log import JOURNAL, SCENERY, SIGNAL, FlightLog
from crazychoir_fw.recording.journal_columns import JournalColumns, Member
from crazychoir_fw.recording.log_stream import StreamFile
from crazychoir_fw.recording.record_output import requests_of
from crazychoir_fw.recording.samples import StreamedSamples
from crazychoir_fw.recording.signals import scenery_of, signals_of

_GROUP_BYTES = 1 << 24
_PIECE_BYTES = 1 << 20
_READING = 0.2  # share of the work; the rest is packing
_MAX_KEPT = 3000  # samples of the log that is returned


def archive(
    stream: Path,
    path: Path,
    metadata: Mapping[str, Any],
    events: Sequence[Mapping[str, Any]],
    tell: Callable[[float], object] = lambda share: None,
) -> FlightLog:
    """Write the log of a flight of one recorder that was never taken back in time, as `FlightLog.save` would.

    Args:
        stream: Its stream, which is complete.
        path: The log.
        metadata: What the log says about the flight.
        events: What happened.
        tell: Called with the share that is done, 0 to 1, now and then.

    Returns:
        A log of some thousand samples of the flight and without its journal, for plots.

    Raises:
        OSError: If a file cannot be read or written.
        ValueError: If it is no such stream.
    """
    file = StreamFile(stream)
    headers = {frame.section: file.json(frame) for frame in file.frames if frame.kind == b"H"}
    if set(headers) != {0}:
        raise ValueError(f"{stream} has the sections {sorted(headers)}, expected one recorder")
    header, samples = headers[0], StreamedSamples(file, 0, headers[0])
    about = dict(metadata)
    drones = list(map(str, header["drones"]))
    with ExitStack() as stack:
        scratch = stack.enter_context(tempfile.TemporaryFile(dir=path.parent))
        columns = _Columns(scratch, len(samples))
        thin = _Thinned(len(samples))
        journal = _journal(stack, path.parent, file, header["recipe"])
        temporary = stack.enter_context(replacing(path))
        for count, column in samples.chunks(_GROUP_BYTES):
            signals = signals_of(header["layout"], column)
            group = {"time": column("time"), **{SIGNAL + name: values for name, values in signals.items()}}
            scenery = scenery_of(header["layout"], column)
            if scenery is not None:
                group[SCENERY] = scenery
            if journal is not None:
                group[JOURNAL + "samples"] = column("requests")
            columns.add(count, group)
            thin.add(count, group["time"], signals)
            tell(_READING * columns.share)
        with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, allowZip64=True) as packed:
            for done, member in enumerate(columns.members(), 1):
                _write_member(packed, "", member)
                tell(_READING + (1.0 - _READING) * done / len(columns))
            for member in () if journal is None else journal.members():
                _write_member(packed, JOURNAL, member)
            for name, text in (("metadata", json.dumps(about)), ("events", json.dumps(list(events)))):
                _write_array(packed, name, np.array(text))
            _write_array(packed, "drone_ids", np.array(drones, np.str_))
    return FlightLog(thin.time, drones, thin.signals, about, [dict(event) for event in events])


class _Columns:
    """Arrays of many rows, filled by groups of rows, in a file."""

    def __init__(self, file: IO[bytes], rows: int) -> None:
        self._file, self._rows, self._filled = file, rows, 0
        self._places: dict[str, tuple[int, tuple[int, ...], np.dtype]] = {}
        self._end = 0

    def __len__(self) -> int:
        return len(self._places)

    @property
    def share(self) -> float:
        """How much is filled, 0 to 1."""
        return self._filled / self._rows if self._rows else 1.0

    def add(self, count: int, group: Mapping[str, NDArray[Any]]) -> None:
        """Write the next rows of all arrays; the first group says which there are."""
        for name, values in group.items():
            if name not in self._places:
                self._places[name] = self._end, values.shape[1:], values.dtype
                self._end += self._rows * self._row_bytes(name)
            self._file.seek(self._places[name][0] + self._filled * self._row_bytes(name))
            self._file.write(np.ascontiguousarray(values).data if values.size else b"")
        self._filled += count

    def _row_bytes(self, name: str) -> int:
        _, shape, dtype = self._places[name]
        return int(np.prod(shape, dtype=np.int64)) * dtype.itemsize

    def members(self) -> Iterator[Member]:
        """Give each array."""
        for name, (offset, shape, dtype) in self._places.items():
            yield name, (self._rows, *shape), dtype, _pieces(self._file, offset, self._rows * self._row_bytes(name))


def _pieces(file: IO[bytes], offset: int, size: int) -> Iterator[bytes]:
    while size:
        file.seek(offset)
        piece = file.read(min(size, _PIECE_BYTES))
        if not piece:
            raise OSError("the scratch file of a log was cut")
        yield piece
        offset, size = offset + len(piece), size - len(piece)


class _Thinned:
    """Evenly chosen samples, few enough to be drawn."""

    def __init__(self, rows: int) -> None:
        self._stride = -(-rows // _MAX_KEPT) or 1
        self._seen = 0
        self._times: list[NDArray[Any]] = []
        self._signals: dict[str, list[NDArray[Any]]] = {}

    def add(self, count: int, time: NDArray[Any], signals: Mapping[str, NDArray[Any]]) -> None:
        first = -self._seen % self._stride
        self._seen += count
        self._times.append(time[first :: self._stride].copy())
        for name, values in signals.items():
            if name in _DRAWN:
                self._signals.setdefault(name, []).append(values[first :: self._stride].copy())

    @property
    def time(self) -> NDArray[Any]:
        return np.concatenate([np.empty(0), *self._times])

    @property
    def signals(self) -> dict[str, NDArray[Any]]:
        return {name: np.concatenate(pieces) for name, pieces in self._signals.items()}


_DRAWN = frozenset(
    f"{group}.{name}"
    for group, names in (
        ("sim", ("x", "y", "z")),
        ("stateEstimate", ("x", "y", "z")),
        ("layers", ("x", "y", "z", "phase")),
        ("ctrltarget", ("x", "y", "z")),
        ("motor", ("m1", "m2", "m3", "m4")),
    )
    for name in names
)


def _journal(stack: ExitStack, folder: Path, file: StreamFile, recipe: dict[str, Any] | None) -> JournalColumns | None:
    """Return the requests of a stream in scratch files, None for what has no journal."""
    if recipe is None:
        return None

    def scratch() -> IO[bytes]:
        return stack.enter_context(tempfile.TemporaryFile(dir=folder))

    columns = JournalColumns(recipe, scratch)
    for frame in file.of(b"J", 0):
        more = requests_of(file.payload(frame), trusted=True)
        if more.forgotten != columns.count:
            raise ValueError("the flight was taken back in time while it was recorded")
        columns.extend(more.to_arrays())
    return columns


def _write_member(packed: zipfile.ZipFile, prefix: str, member: Member) -> None:
    """Write an array as a member `name.npy`, piece by piece."""
    name, shape, dtype, pieces = member
    head = io.BytesIO()
    npy.write_array_header_1_0(head, {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": shape})
    with packed.open(f"{prefix}{name}.npy", "w", force_zip64=True) as file:
        file.write(head.getvalue())
        for piece in pieces:
            file.write(piece)


def _write_array(packed: zipfile.ZipFile, name: str, values: NDArray[Any]) -> None:
    with packed.open(f"{name}.npy", "w", force_zip64=True) as member:
        npy.write_array(member, values, allow_pickle=False)
