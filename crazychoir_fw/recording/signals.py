"""Signals of a log out of the samples of a flight, while it is in memory or out of a file.

A layout says what the fields of a row are, as plain data: stretches of the memory of drones (`world_layout`), or poses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import rotation_of_quaternion, rpy_of_rotation

Array = NDArray[np.float64]
Column = Callable[[str], NDArray[Any]]
"""Returns a field of all samples, shape (T, ...)."""

EXTRA = "extra/"  # prefix of fields that are signals as they are

_WORD = 4  # [bytes]
_TURNED_AT_ONCE = 256  # rows, which a cache holds: three times as fast as all of them

_FEW = 32  # variables that are read one by one before all words are turned

_TRUTH = {
    **{name: ("_pose", i) for i, name in enumerate(("sim.x", "sim.y", "sim.z"))},
    **{f"sim.v{axis}": ("_twist", i) for i, axis in enumerate("xyz")},
    **{f"sim.w{axis}": ("_twist", 3 + i) for i, axis in enumerate("xyz")},
    **{f"sim.{angle}": ("_angles", i) for i, angle in enumerate(("roll", "pitch", "yaw"))},
}
"""What the simulator knows: where it is found, and at which place there."""
POSE_FIELDS = ("position", "velocity", "orientation")


class LazySignals(MutableMapping[str, NDArray[Any]]):
    """Signals of a flight that are computed when they are first asked for: a judge reads ten of four hundred."""

    def __init__(self, layout: Mapping[str, Any], column: Column) -> None:
        """Take the samples of a world, see `signals_of`."""
        self._layout = layout
        self._parts = [f"part{k}" for k in range(len(layout["parts"]))]
        others = ["qpos", "motion", *(EXTRA + name for name in layout["extra"])]
        self._columns = {field: column(field) for field in (*self._parts, *others)}
        self._world = _WorldSignals(layout, self._columns.__getitem__)
        self._signals: dict[str, NDArray[Any] | None] = dict.fromkeys(self._world.names)

    def __getitem__(self, name: str) -> NDArray[Any]:
        samples = self._signals[name]
        if samples is None:
            samples = self._signals[name] = self._world.read(name)
        return samples

    def __setitem__(self, name: str, samples: NDArray[Any]) -> None:
        self._signals[name] = samples

    def __delitem__(self, name: str) -> None:
        del self._signals[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._signals)

    def __len__(self) -> int:
        return len(self._signals)

    def __contains__(self, name: object) -> bool:
        return name in self._signals

    def raw(self) -> Iterator[NDArray[Any]]:
        """Yield the samples that all of them are computed from; what lies between them in memory is zero."""
        for field, samples in self._columns.items():
            if field in self._parts:
                for begin, end in _gaps(self._layout["parts"][self._parts.index(field)]["places"], samples.shape[2]):
                    samples[:, :, begin:end] = 0
            yield samples


def signals_of(layout: Mapping[str, Any], column: Column) -> dict[str, NDArray[Any]]:
    """Return the signals of samples, (T, N) each.

    Args:
        layout: What the fields are: ``parts``, ``drones`` and ``qpos`` of a world, or ``poses``, names of groups of
            signals; and ``extra``, names of further signals.
        column: Their values.
    """
    if "parts" in layout:
        world = _WorldSignals(layout, column)
        return {name: world.read(name) for name in world.names}
    signals: dict[str, NDArray[Any]] = {}
    for group in layout["poses"]:
        signals |= motion_signals(group, *(column(f"{group}/{name}") for name in POSE_FIELDS))
    return signals | {name: column(EXTRA + name) for name in layout["extra"]}


def scenery_of(layout: Mapping[str, Any], column: Column) -> NDArray[np.float32] | None:
    """Return positions of what moves beside the drones, shape (T, any), or None if nothing does."""
    columns = layout.get("scenery")
    return column("qpos")[:, columns].astype(np.float32) if columns else None


def _gaps(places: Mapping[str, tuple[int, str]], size: int) -> list[tuple[int, int]]:
    """Return what no variable covers of so many bytes, from places and types of all variables."""
    gaps, covered = [], 0
    for begin, kind in sorted(places.values()):
        if begin > covered:
            gaps.append((covered, begin))
        covered = max(covered, begin + np.dtype(kind).itemsize)
    return [*gaps, (covered, size)] if covered < size else gaps


class _WorldSignals:
    """Every log variable of the drones of a world, where they were and how they moved, and further signals."""

    def __init__(self, layout: Mapping[str, Any], column: Column) -> None:
        self._column = column
        self._layout = layout
        self._cells = [_Cells(partial(column, f"part{k}")) for k in range(len(layout["parts"]))]
        self.names = dict.fromkeys(
            [name for part in layout["parts"] for name in part["places"]] + [*_TRUTH, *layout["extra"]]
        )
        """All names, in the order of a log."""

    def read(self, name: str) -> NDArray[Any]:
        """Return a signal, shape (T, N)."""
        if name in self._layout["extra"]:
            return self._column(EXTRA + name)
        if name in _TRUTH:
            of, i = _TRUTH[name]
            samples: NDArray[Any] = getattr(self, of)[..., i].astype(np.float32)
            return samples
        found = []
        for part, cells in zip(self._layout["parts"], self._cells, strict=True):
            if name in part["places"]:
                place, kind = part["places"][name]
                found.append((np.array(part["numbers"], np.intp), cells.read(place, np.dtype(kind))))
        return _joined(found, self._layout["drones"])

    @cached_property
    def _pose(self) -> Array:
        """Of all drones, shape (T, N, 7)."""
        qpos = self._column("qpos")
        return np.stack([qpos[:, address : address + 7] for address in self._layout["qpos"]], axis=1)

    @cached_property
    def _twist(self) -> Array:
        """Of all drones, shape (T, N, 6)."""
        return self._column("motion")

    @cached_property
    def _angles(self) -> Array:
        return roll_pitch_yaw_deg(self._pose[..., 3:7])


class _Cells:
    """Variables out of copies of memory, (T, N, bytes)."""

    def __init__(self, copies: Callable[[], NDArray[np.uint8]]) -> None:
        self._load = copies
        self._few = _FEW

    @cached_property
    def _copies(self) -> NDArray[np.uint8]:
        return self._load()

    def read(self, place: int, dtype: np.dtype) -> NDArray[Any]:
        """Return a variable by place and type, shape (T, N)."""
        copies = self._copies
        self._few -= 1
        if self._few >= 0 or copies.shape[2] % _WORD:  # of a version that copied no whole words
            cells = np.ascontiguousarray(copies[:, :, place : place + dtype.itemsize])
            return cells.view(dtype)[..., 0]
        words = self._words
        first, skipped = divmod(place, _WORD)
        count = -(-(skipped + dtype.itemsize) // _WORD)
        if count == 1 and dtype.itemsize == _WORD:
            return words[first].view(dtype)
        if count == 1 and skipped % dtype.itemsize == 0 and _WORD % dtype.itemsize == 0:
            parts = words[first].view(dtype).reshape(*copies.shape[:2], -1)
            return np.ascontiguousarray(parts[..., skipped // dtype.itemsize])
        joined = words[first] if count == 1 else np.stack(list(words[first : first + count]), axis=-1)
        cells = joined.view(np.uint8).reshape(*copies.shape[:2], count * _WORD)[..., skipped : skipped + dtype.itemsize]
        return np.ascontiguousarray(cells).view(dtype)[..., 0]

    @cached_property
    def _words(self) -> NDArray[np.uint32]:
        """The copies, turned word by word.

        Variable by variable, memory would be walked through as often as there are variables, which takes five times as
        long.
        """
        source = self._copies.view(np.uint32)
        words = np.empty((source.shape[2], *source.shape[:2]), np.uint32)
        for begin in range(0, len(source), _TURNED_AT_ONCE):
            rows = slice(begin, begin + _TURNED_AT_ONCE)
            words[:, rows] = np.moveaxis(source[rows], 2, 0)
        return words


def motion_signals(group: str, position: Array, velocity: Array, orientation: Array) -> dict[str, NDArray[np.float32]]:
    """Return positions (m), velocities (m/s) and angles (deg) as signals, (T, N) each.

    Args:
        group: What their names begin with.
        position: Shape (T, N, 3).
        velocity: Shape (T, N, 3).
        orientation: Quaternions xyzw, shape (T, N, 4).
    """
    signals: dict[str, NDArray[Any]] = {}
    for prefix, values in (("", position), ("v", velocity)):
        for k, axis in enumerate("xyz"):
            signals[f"{group}.{prefix}{axis}"] = values[..., k].astype(np.float32)
    angles = np.degrees(rpy_of_rotation(rotation_of_quaternion(orientation)))
    # the pitch of the onboard log is positive for a nose that rises
    for k, (name, sign) in enumerate((("roll", 1.0), ("pitch", -1.0), ("yaw", 1.0))):
        signals[f"{group}.{name}"] = (sign * angles[..., k]).astype(np.float32)
    return signals


def merged(names: Sequence[str], parts: Sequence[tuple[Sequence[int], Mapping[str, NDArray[Any]]]]) -> dict[str, Any]:
    """Return the signals of a swarm that several recorders saw, under the names of the first of them.

    What only the drones of the first have is NaN for the others; their truth is what is known of them.

    Args:
        names: All drones, N.
        parts: Which drones each recorder saw, and their signals, (T, n) each.
    """
    (first, signals), *others = parts
    whole = {}
    for name, values in signals.items():
        dtype = np.float64 if values.itemsize > 4 else np.float32
        whole[name] = np.full((len(values), len(names)), np.nan, dtype)
        whole[name][:, first] = values
        for numbers, theirs in others:
            known = theirs.get(name, theirs.get(name.replace("sim.", "stateEstimate.")))
            if known is not None:
                whole[name][:, numbers] = known
    return whole


def _joined(part_samples: Sequence[tuple[NDArray[np.intp], NDArray[Any]]], count: int) -> NDArray[Any]:
    """Return a signal of the whole swarm, shape (T, N), from those of its parts, each (T, n) with its columns."""
    columns, samples = part_samples[0]
    if len(part_samples) == 1 and len(columns) == count:
        return samples
    dtype = np.result_type(*(own for _, own in part_samples))
    if sum(len(columns) for columns, _ in part_samples) < count and dtype.kind != "f":
        # the smallest float that holds every value and NaN
        dtype = np.result_type(dtype, np.float16 if dtype.itemsize == 1 else np.float32)
    joined = np.zeros((len(samples), count), dtype)
    if dtype.kind == "f":
        joined[:] = np.nan
    for columns, own in part_samples:
        joined[:, columns] = own
    return joined


def roll_pitch_yaw_deg(quat_wxyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return roll, pitch and yaw (deg) of quaternions of shape (..., 4).

    Pitch has the legacy sign of the firmware, positive lifts the nose, so that it compares with
    ``stateEstimate.pitch``.
    """
    w, x, y, z = np.moveaxis(quat_wxyz, -1, 0)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = -np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.degrees(np.stack([roll, pitch, yaw], axis=-1))
