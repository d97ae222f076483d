"""Trajectories on their way into the memory of a drone.

The memory port is docs/reference/crtp-cflib.md#10, the bytes are docs/reference/planner-commander.md#4.1.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.mem import MemoryElement
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RadioError, RangeError
from crazychoir_fw.common.trajectory_files import MEMORY_PIECES

_PIECE_FLOATS = 33
HIGHEST_ID = 30
"""Trajectories have the ids 0 to 30."""


class _Piece:
    """What cflib writes: anything that packs itself."""

    def __init__(self, row: NDArray[np.float32]) -> None:
        self._row = row

    def pack(self) -> bytes:
        return self._row.tobytes()


def checked_pieces(who: str, pieces: ArrayLike) -> NDArray[np.float32]:
    """Return pieces as the memory takes them, shape (n, 33).

    Raises:
        RangeError: If they have another shape, are not finite, last no time, or are too many.
    """
    rows = np.ascontiguousarray(pieces, dtype="<f4")
    if rows.ndim != 2 or rows.shape[1] != _PIECE_FLOATS or not 1 <= len(rows) <= MEMORY_PIECES:
        raise RangeError(f"{who}: pieces have shape {rows.shape}, allowed: (n, 33) with n from 1 to {MEMORY_PIECES}")
    if not np.all(np.isfinite(rows)) or not np.all(rows[:, -1] > 0.0):
        raise RangeError(f"{who}: pieces must be finite numbers, and last longer than 0 s")
    return rows


def upload(cf: Crazyflie, who: str, trajectory_id: int, rows: NDArray[np.float32], timeout_s: float) -> None:
    """Write pieces into the memory and define them as one trajectory; waits until the drone has confirmed.

    Not from a callback of cflib, which would wait for itself; one at a time for each drone.

    Args:
        cf: A connected drone.
        who: Name and URI, for errors.
        trajectory_id: 0 to 30.
        rows: Pieces as `checked_pieces` returns them.
        timeout_s: How long it may take (s).

    Raises:
        RadioError: If the drone has no such memory, refuses, or does not confirm in time.
    """
    memories: list[Any] = cf.mem.get_mems(MemoryElement.TYPE_TRAJ)
    if not memories:
        raise RadioError(f"{who}: the drone has no trajectory memory")
    done, refused = threading.Event(), threading.Event()

    def refuse(*_: object) -> None:
        refused.set()
        done.set()

    memory = memories[0]
    memory.trajectory = [_Piece(row) for row in rows]
    memory.write_data(lambda *_: done.set(), refuse)
    if not done.wait(timeout_s):
        raise RadioError(f"{who}: the trajectory was not written within {timeout_s:g} s")
    if refused.is_set():
        raise RadioError(f"{who}: the drone refused the trajectory")
    cf.high_level_commander.define_trajectory(trajectory_id, 0, len(rows))
