"""Everything that a world is at one instant, in memory or in a file."""

from __future__ import annotations

import json
import lzma
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.reading import printable
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation.events import Event
from crazychoir_fw.simulation.fingerprint import Fingerprint, difference

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""What MuJoCo calls the state: time, motion, warm start of the solver, applied forces, active equality constraints,
poses of mocap bodies, memory of plugins, and with it every byte of every drone."""

BESIDE_THE_STATE = ("tree_asleep",)
"""Arrays of mjData that the next step depends on and that are not part of that state. This is the place to add one."""

_FORMAT = "crazychoir_fw snapshot 1"
_JOURNAL = "journal/"

_LATEST_S = 1e9
"""Latest time of a world (s), three decades: ticks count to here exactly."""

LARGEST = 2**31
"""Size of an unpacked file (bytes): a thousand drones take 60 MB, a journal 40 bytes per request."""

# what reading an archive raises that was changed at any byte
_DAMAGES = (
    *(ValueError, KeyError, TypeError, AttributeError, IndexError, EOFError, OSError, MemoryError, OverflowError),
    *(RuntimeError, struct.error, zlib.error, lzma.LZMAError, tokenize.TokenError, SyntaxError, zipfile.BadZipFile),
)


@dataclass(frozen=True, repr=False)
class Snapshot:
    """A world at one instant. As an array it is the row of state that `mujoco.batch` and `mujoco.rollout` take."""

    state: NDArray[np.float64]
    """The state in the order of `mj_getState` with `STATE`."""
    beside: dict[str, NDArray[Any]]
    """Arrays of `BESIDE_THE_STATE`."""
    fingerprint: Fingerprint
    """Which worlds it fits."""
    time: float
    """Simulated time (s)."""
    events: tuple[Event, ...] = ()
    """What had happened until then."""
    journal: Journal = field(default_factory=Journal)
    """The requests that led there."""
    is_trusted: bool = True
    """Whether its bytes were never out of this process, or the caller vouches for their file."""

    def __repr__(self) -> str:
        return f"<Snapshot at {self.time:.3f} s, {self.state.nbytes / 1024:.0f} KiB>"

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Return the row of state, so that ``batch.state[:] = snapshot`` works."""
        return np.array(self.state, dtype=dtype) if copy else np.asarray(self.state, dtype=dtype)

    def __deepcopy__(self, memo: dict[int, Any]) -> Snapshot:
        """Return the same one: it does not change."""
        del memo
        return self

    def tobytes(self) -> bytes:
        """Return the state as bytes: two worlds are alike when these are equal."""
        return self.state.tobytes()

    def save(self, path: str | Path) -> None:
        """Write a file that `load` reads in any process; an existing one is replaced in one step."""
        about = {
            "format": _FORMAT,
            "fingerprint": dict(self.fingerprint),
            "time": self.time,
            "events": [event.as_dict() for event in self.events],
        }
        members = {f"beside/{name}": values for name, values in self.beside.items()}
        members |= {_JOURNAL + name: values for name, values in self.journal.to_arrays().items()}
        with replacing(Path(path)) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, about=np.array(json.dumps(about)), state=self.state, **members)

    @classmethod
    def load(cls, path: str | Path, *, trust: bool = False) -> Snapshot:
        """Read a file written by `save`; nothing in it is ever executed.

        Args:
            path: The file.
            trust: Whether you trust the author of the file. Otherwise a world checks every number of it that C relies
                on, and refuses drones that fly the library of a checkout, whose memory nothing here understands.

        Raises:
            FileNotFoundError: If there is no such file.
            RangeError: If it is no snapshot.
        """
        try:
            if Path(path).is_file() and not zipfile.is_zipfile(path):
                raise ValueError("it is no NumPy archive (.npz)")  # where np.load would guess, and speak of pickles
            _check_size(path)
            with np.load(path, allow_pickle=False) as file:
                about = json.loads(str(file["about"]))
                if about["format"] != _FORMAT:
                    raise ValueError(f"its format is '{about['format']}', this version reads '{_FORMAT}'")
                return cls(
                    state=file["state"].astype(np.float64, casting="no"),
                    beside={name: file[f"beside/{name}"] for name in BESIDE_THE_STATE},
                    fingerprint=about["fingerprint"],
                    time=float(about["time"]),
                    events=tuple(Event(**event) for event in about["events"]),
                    is_trusted=trust,
                    journal=Journal.from_arrays(
                        {name[len(_JOURNAL) :]: file[name] for name in file.files if name.startswith(_JOURNAL)}
                    ),
                )
        except FileNotFoundError:
            raise
        except _DAMAGES as error:
            raise RangeError(printable(f"{path} is not a snapshot: {error}")) from error


def _check_size(path: str | Path) -> None:
    """Refuse an archive that becomes too much, before it is unpacked."""
    with zipfile.ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
    if size > LARGEST:
        raise ValueError(f"it unpacks to {size} bytes, allowed: at most {LARGEST}")


def read_state(model: mujoco.MjModel, data: mujoco.MjData) -> NDArray[np.float64]:
    """Return the row of state of a world."""
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state


def take(
    model: mujoco.MjModel, data: mujoco.MjData, fingerprint: Fingerprint, events: tuple[Event, ...], journal: Journal
) -> Snapshot:
    """Return a snapshot of a world."""
    beside = {name: getattr(data, name).copy() for name in BESIDE_THE_STATE if hasattr(data, name)}
    return Snapshot(read_state(model, data), beside, fingerprint, float(data.time), events, journal.copy())


def put(
    snapshot: Snapshot,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    fingerprint: Fingerprint,
    check: Callable[[NDArray[np.float64]], None],
) -> None:
    """Make a world what it was.

    Args:
        snapshot: The snapshot.
        model: The compiled world.
        data: Its state, which is replaced.
        fingerprint: What the world is.
        check: Called with the memory of all plugins of a snapshot that is not trusted, before anything is replaced.

    Raises:
        RangeError: If the snapshot is one of another world, or `check` refuses it.
    """
    differs = difference(snapshot.fingerprint, fingerprint)
    if differs is not None:
        raise RangeError(f"the snapshot belongs to another world: it {differs}")
    if not _fits(snapshot, model, data):
        raise RangeError(f"the snapshot is damaged: {snapshot.state.shape} numbers do not fit the world that it names")
    if not snapshot.is_trusted:
        apart = mujoco.MjData(model)
        mujoco.mj_setState(model, apart, snapshot.state, STATE)
        for time in (float(apart.time), snapshot.time):
            if not 0.0 <= time <= _LATEST_S:  # NaN as well
                raise RangeError(f"the snapshot is damaged: its time is {time} s, allowed: 0 to {_LATEST_S:g} s")
        check(apart.plugin_state)
    mujoco.mj_setState(model, data, snapshot.state, STATE)
    for name, values in snapshot.beside.items():
        getattr(data, name)[:] = values
    # for a look before the next step, which starts with the same; nothing of the state depends on it
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)


def _fits(snapshot: Snapshot, model: mujoco.MjModel, data: mujoco.MjData) -> bool:
    def is_like(values: ArrayLike, other: NDArray[Any]) -> bool:
        return np.shape(values) == other.shape and np.asarray(values).dtype == other.dtype

    return snapshot.state.shape == (mujoco.mj_stateSize(model, STATE),) and all(
        hasattr(data, name) and is_like(values, getattr(data, name)) for name, values in snapshot.beside.items()
    )
