"""Reads the stream of a flight that was cut off, or that still flies, as its log would be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.recording.log_stream import FLIGHT, StreamFile
from crazychoir_fw.recording.record_output import requests_of
from crazychoir_fw.recording.samples import StreamedSamples
from crazychoir_fw.recording.signals import merged, scenery_of, signals_of


def read_cut(path: Path) -> dict[str, Any]:
    """Return the fields of a `FlightLog`; its metadata say in ``cut`` that the flight has no end.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is no stream, or has no sample yet.
    """
    file = StreamFile(path)
    headers = {frame.section: file.json(frame) for frame in file.frames if frame.kind == b"H"}
    swarm = headers.pop(FLIGHT, None)
    if 0 not in headers:
        raise ValueError("it has no sample yet")
    parts = [_part(file, section, headers[section]) for section in sorted(headers)]
    first = parts[0]
    count = min(len(part["time"]) for part in parts)
    signals = [{name: values[:count] for name, values in part["signals"].items()} for part in parts]
    drones, journal = headers[0]["drones"], first["journal"]
    if swarm is not None:
        if len(swarm["numbers"]) != len(parts):
            raise ValueError("parts of the swarm are missing")
        drones, journal = swarm["names"], None
        signals = [merged(drones, list(zip(swarm["numbers"], signals, strict=True)))]
    if journal is not None:
        journal.samples = first["requests"][:count]
    events = [event for frame in file.frames if frame.kind == b"E" for event in file.json(frame)]
    cut = _end(file, first["time"][:count])
    return {
        "time": first["time"][:count],
        "drone_ids": drones,
        "signals": signals[0],
        "metadata": {**headers[0]["metadata"], "cut": cut},
        "events": sorted(events, key=lambda event: event["time"]),
        "journal": journal,
        "scenery": None if first["scenery"] is None else first["scenery"][:count],
    }


def _end(file: StreamFile, time: Any) -> str:
    """Say where a flight was cut off (s)."""
    torn = "; its last record was torn and is dropped" if file.is_torn else ""
    return f"the flight was cut off at {time[-1]:.3f} s{torn}" if len(time) else f"nothing was flown{torn}"


def _part(file: StreamFile, section: int, header: dict[str, Any]) -> dict[str, Any]:
    """Return what one recorder saw."""
    samples = StreamedSamples(file, section, header)
    time = samples.column("time")
    # a flight that was taken back: what comes later in the file takes the place of the same time and what is after it
    kept: Any = slice(None)
    if np.any(np.diff(time) < 0.0):
        ends = np.minimum.accumulate(time[::-1])[::-1]
        kept = np.append(time[:-1] < ends[1:], True)
    signals = signals_of(header["layout"], samples.column)
    scenery = scenery_of(header["layout"], samples.column)
    part: dict[str, Any] = {"scenery": None if scenery is None else scenery[kept]}
    part |= {"time": time[kept], "signals": {name: values[kept] for name, values in signals.items()}, "journal": None}
    if header["recipe"] is not None:
        part["journal"] = _journal(file, section, header["recipe"])
        part["requests"] = np.asarray(samples.column("requests"))[kept].tolist()
    return part


def _journal(file: StreamFile, section: int, recipe: dict[str, Any]) -> Journal:
    journal = Journal(recipe)
    for frame in file.of(b"J", section):
        more = requests_of(file.payload(frame))
        if more.forgotten != len(journal):
            journal = Journal(recipe)  # the world was taken back, which is the gap of what follows
        journal.extend(more)
    return journal
