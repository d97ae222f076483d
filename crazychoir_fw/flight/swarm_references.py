"""The references of several drones as arrays, for controllers that take all of them at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Reference

Array = NDArray[np.float64]

_VECTORS = ("position", "velocity", "acceleration", "jerk")
_SHAPES = {**dict.fromkeys(_VECTORS, (3,)), "yaw": (), "yaw_rate": ()}
"""What a reference consists of, for one drone."""


class SwarmReferences:
    """Rows of N drones; the row of a drone that holds its place, by a reference that cannot be written to, stays."""

    def __init__(self, count: int) -> None:
        """Begin without references of so many drones."""
        self._kept: list[Reference | None] = [None] * count  # references whose rows stay while they stay
        self._values: dict[str, Array] = {name: np.zeros((count, *shape)) for name, shape in _SHAPES.items()}
        self._is_given = {name: np.zeros(count, bool) for name in _SHAPES}
        self._given = dict.fromkeys(_SHAPES, 0)  # by so many drones
        self._is_full = [False] * count  # whose reference had all parts

    def update(self, references: Sequence[Reference | None]) -> None:
        """Take the present reference of each drone, None where it has none."""
        rows, full = [], []
        for k, (reference, kept) in enumerate(zip(references, self._kept, strict=True)):
            if reference is not None and reference is kept:
                continue
            self._kept[k] = None
            if self._is_full[k] and reference is not None and _has_all_parts(reference):
                rows.append(k)
                full.append(reference)
            else:
                self._write(k, reference)
        if full:
            self._write_full(rows, full)

    def _write_full(self, rows: list[int], references: list[Reference]) -> None:
        """Write rows of drones whose references had all parts before, and have them now: moving ones mostly."""
        vectors = np.array([(one.position, one.velocity, one.acceleration, one.jerk) for one in references], float)
        angles = np.array([(one.yaw, one.yaw_rate) for one in references], float)
        where = slice(None) if len(rows) == len(self._kept) else rows
        for k, name in enumerate(_VECTORS):
            self._values[name][where] = vectors[:, k]
        self._values["yaw"][where], self._values["yaw_rate"][where] = angles.T

    def _write(self, k: int, reference: Reference | None) -> None:
        for name, values in self._values.items():
            value = getattr(reference, name, None)
            is_given = self._is_given[name]
            if value is not None:
                values[k] = value
            elif is_given[k]:
                values[k] = 0.0
            if (value is not None) != is_given[k]:
                is_given[k] = value is not None
                self._given[name] += 1 if is_given[k] else -1
        self._is_full[k] = reference is not None and _has_all_parts(reference)
        self._kept[k] = reference if reference is not None and _is_constant(reference) else None

    def arrays(self, places: Array) -> dict[str, Array]:
        """Return the parts of references that some drone has, zero for the others, as new arrays, shape (N, ...).

        Args:
            places: Positions of the drones whose references have none (m, world), shape (N, 3).
        """
        parts = {name: values.copy() for name, values in self._values.items() if self._given[name]}
        if self._given["position"] < len(places):
            parts["position"] = np.where(self._is_given["position"][:, None], self._values["position"], places)
        return parts


def _has_all_parts(reference: Reference) -> bool:
    return not (
        reference.position is None
        or reference.velocity is None
        or reference.acceleration is None
        or reference.jerk is None
        or reference.yaw is None
        or reference.yaw_rate is None
        or _is_constant(reference)  # its row is written once
    )


def _is_constant(reference: Reference) -> bool:
    """Return whether no code can write to the vectors of a reference, as those of the end of a trajectory."""
    vectors = (reference.position, reference.velocity, reference.acceleration, reference.jerk)
    return all(isinstance(vector, np.ndarray) and not vector.flags.writeable for vector in vectors)
