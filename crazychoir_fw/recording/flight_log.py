"""The record of a flight: named signals of every drone over one time axis.

Names are those of the onboard log (`stateEstimate.x`, `ctrltarget.x`, `motor.m1`, `pm.vbat`), with the onboard units.
The truth of the simulator stands beside them as `sim.x`, `sim.y`, `sim.z` (m), `sim.vx`, ... (m/s, world frame),
`sim.roll`, `sim.pitch`, `sim.yaw` (deg) and `sim.wx`, ... (rad/s, body frame).
"""

import json
import os
import zipfile
from collections.abc import MutableMapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.recording.cut_log import read_cut
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.recording.log_stream import STREAM
from crazychoir_fw.recording.signals import LazySignals

SIGNAL = "signal/"
"""Prefix of the signals among the members of the file."""
JOURNAL = "journal/"
"""Prefix of the columns of the journal."""
SCENERY = "scenery"
_MAX_MEMBERS = 20_000  # a log has some hundreds


@dataclass(repr=False)
class FlightLog:
    """Signals of N drones at T instants."""

    time: NDArray[np.float64]  # (T,)
    """Simulated time (s), never decreasing."""

    drone_ids: list[str]  # N
    """Names of the drones, in the order of the columns of the signals."""

    signals: MutableMapping[str, NDArray[Any]] = field(default_factory=dict)  # each (T, N)
    """Samples by `group.name`; those of `LazySignals` are computed when they are first asked for."""

    metadata: dict[str, Any] = field(default_factory=dict)
    """What flew: mission, provider, version, seed and so on; anything that JSON can hold."""

    events: list[dict[str, Any]] = field(default_factory=list)
    """What happened at instants: `time` (s), `kind`, `drone` (or None) and `details` each."""

    journal: Journal | None = None
    """Every request that reached a drone, and how to build the world: what `crazychoir replay` flies from."""

    scenery: NDArray[np.float32] | None = None
    """Positions of what moves beside the drones, such as payloads, as in ``qpos``, shape (T, any); None: nothing."""

    def __post_init__(self) -> None:
        """Refuse shapes that do not fit together.

        Raises:
            ValueError: If a signal is not (T, N), is not numeric, or time runs backwards.
        """
        self.time = np.asarray(self.time, dtype=np.float64)
        self.drone_ids = [str(drone) for drone in self.drone_ids]
        if self.time.ndim != 1:
            raise ValueError(f"time has shape {self.time.shape}, expected (T,)")
        # negated, so that NaN is refused as well
        if not np.all(np.diff(self.time) >= 0.0):
            raise ValueError("time must not decrease")
        if isinstance(self.signals, LazySignals):
            return
        shape = (len(self.time), len(self.drone_ids))
        for name, samples in self.signals.items():
            samples = np.asarray(samples)
            if samples.shape != shape:
                raise ValueError(f"signal {name} has shape {samples.shape}, expected (T, N) = {shape}")
            if samples.dtype.kind not in "biuf":
                raise ValueError(f"signal {name} has type {samples.dtype}, expected numbers")
            self.signals[name] = samples

    def __repr__(self) -> str:
        return f"FlightLog({len(self.drone_ids)} drones, {self.duration_s:g} s, {len(self.signals)} signals)"

    @property
    def duration_s(self) -> float:
        """Time between the first and the last sample (s)."""
        return float(self.time[-1] - self.time[0]) if len(self.time) else 0.0

    def stack(self, *names: str) -> NDArray[np.float64] | None:
        """Return the named signals side by side, shape (T, N, K), or None if one of them was not recorded."""
        if not all(name in self.signals for name in names):
            return None
        return np.stack([self.signals[name].astype(np.float64) for name in names], axis=-1)

    def between(self, begin: float | None, end: float | None) -> "FlightLog":
        """Return the log from one time to another (s), ends included; None is that of the log.

        Raises:
            ValueError: If there is no sample between them.
        """
        low, high = -np.inf if begin is None else begin, np.inf if end is None else end
        kept = (self.time >= low - 1e-9) & (self.time <= high + 1e-9)
        if not kept.any():
            span = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self.time) else "no time at all"
            raise ValueError(f"from {low:g} to {high:g} s there is no sample, allowed: a part of {span}")
        signals = {name: samples[kept] for name, samples in self.signals.items()}
        scenery = None if self.scenery is None else self.scenery[kept]
        return FlightLog(self.time[kept], self.drone_ids, signals, self.metadata, self.events, self.journal, scenery)

    def reference(self) -> NDArray[np.float64] | None:
        """Return the position set-points (m), shape (T, N, 3), NaN where there is none; None if the log has none.

        It is what layers asked for, `layers.x, y, z`, or `ctrltarget.x, y, z`; three exact zeros are no place.
        """
        reference = self.stack("layers.x", "layers.y", "layers.z")
        if reference is None:
            reference = self.stack("ctrltarget.x", "ctrltarget.y", "ctrltarget.z")
        if reference is None:
            return None
        reference[~np.any(reference, axis=-1)] = np.nan
        return None if np.isnan(reference).all() else reference

    def save(self, path: Path) -> None:
        """Write a compressed NPZ file; *path* is replaced in one step, or left alone if writing fails.

        Raises:
            TypeError: If metadata or events cannot be written as JSON.
        """
        members = {SIGNAL + name: samples for name, samples in self.signals.items()}
        if self.journal is not None:
            members |= {JOURNAL + name: values for name, values in self.journal.to_arrays().items()}
        if self.scenery is not None:
            members[SCENERY] = self.scenery
        metadata = np.array(json.dumps(self.metadata))
        events = np.array(json.dumps(self.events))
        drone_ids = np.array(self.drone_ids, dtype=np.str_)
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, time=self.time, drone_ids=drone_ids, metadata=metadata, events=events, **members)

    @classmethod
    def load(cls, path: Path) -> "FlightLog":
        """Read a file written by `save`, or the stream of a flight that was cut off; nothing in it is ever executed.

        Raises:
            FileNotFoundError: If there is no such file.
            ValueError: If the file is not a flight log.
        """
        path = Path(path)
        try:
            if path.suffix == Path(STREAM).suffix:
                return cls._made_of(read_cut(path))
            return cls._made_of(_members(path))
        except FileNotFoundError:
            raise
        except Exception as error:  # a damaged file makes its readers raise whatever they can
            reason = str(error) or type(error).__name__
            raise ValueError(f"{path} is not a flight log: {reason}") from error

    @classmethod
    def _made_of(cls, fields: dict[str, Any]) -> "FlightLog":
        """Return a log of what a file says, whose types nothing has looked at."""
        if not isinstance(fields["metadata"], dict):
            raise ValueError(f"its metadata are a {type(fields['metadata']).__name__}, expected a mapping")
        if not isinstance(fields["events"], list) or not all(map(_is_event, fields["events"])):
            raise ValueError("its events are no list of events")
        return cls(**fields)


def _is_event(value: Any) -> bool:
    return (
        isinstance(value, dict)
        and isinstance(value.get("time"), int | float)
        and isinstance(value.get("kind"), str)
        and isinstance(value.get("drone"), str | None)
        and isinstance(value.get("details", {}), dict)
    )


def _members(path: Path) -> dict[str, Any]:
    """Return the fields of a log that `FlightLog.save` wrote."""
    if path.is_file() and not zipfile.is_zipfile(path):
        raise ValueError("it is no NumPy archive (.npz)")  # where np.load would guess, and speak of pickles
    _check_size(path)
    with np.load(path, allow_pickle=False) as file:
        journal = {name[len(JOURNAL) :]: file[name] for name in file.files if name.startswith(JOURNAL)}
        return {
            "time": file["time"],
            "drone_ids": file["drone_ids"].tolist(),
            "signals": {name[len(SIGNAL) :]: file[name] for name in file.files if name.startswith(SIGNAL)},
            "metadata": json.loads(str(file["metadata"])),
            # files of version 0.1.0 have neither
            "events": json.loads(str(file["events"])) if "events" in file.files else [],
            "journal": Journal.from_arrays(journal) if journal else None,
            "scenery": file[SCENERY].astype(np.float32) if SCENERY in file.files else None,
        }


def _check_size(path: Path) -> None:
    """Refuse what does not fit into memory once it is unpacked: a few kilobytes may hold terabytes of zeros.

    Raises:
        ValueError: If it does not fit, or has more members than a log.
    """
    with zipfile.ZipFile(path) as archive:
        sizes = [member.file_size for member in archive.infolist()]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if sum(sizes) > memory:
        raise ValueError(f"it takes {sum(sizes) / 1e9:.1f} GB of memory, allowed: {memory / 1e9:.1f} GB, all there is")
    if len(sizes) > _MAX_MEMBERS:
        raise ValueError(f"it has {len(sizes)} members, allowed: {_MAX_MEMBERS}")
