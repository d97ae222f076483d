"""Records every log variable of every drone, and the true motion, at a fixed rate.

A sample copies the stretches of memory that hold log variables, a few calls whatever the number of drones (see
`swarm_views`). Drones with different providers have different variables: a signal that a drone lacks is NaN in its
column, and one that counts in whole numbers becomes a float for the others then, without losing a digit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import identity, provider_identity
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation.stage import scenery_columns
from crazychoir_fw.simulation.swarm_views import swarm_parts
from crazychoir_fw.simulation.world import World

_TRUE_POSE = ("sim.x", "sim.y", "sim.z")
_TRUE_VELOCITY = ("sim.vx", "sim.vy", "sim.vz")
_TRUE_RATES = ("sim.wx", "sim.wy", "sim.wz")
_TRUE_ATTITUDE = ("sim.roll", "sim.pitch", "sim.yaw")


class FlightRecorder:
    """Collects samples of a world; `finish` makes a `FlightLog` of them."""

    def __init__(self, world: World, rate_hz: int = 100) -> None:
        """Prepare to record.

        Args:
            world: The world.
            rate_hz: Samples per simulated second; a divisor of 1000.

        Raises:
            RangeError: If the rate does not divide 1000.
        """
        if not (1 <= rate_hz <= TICKS_PER_SECOND and TICKS_PER_SECOND % rate_hz == 0):
            raise RangeError(f"rate_hz is {rate_hz}, allowed: a divisor of {TICKS_PER_SECOND}")
        self._world = world
        self.ticks_per_sample = TICKS_PER_SECOND // rate_hz
        self._parts = swarm_parts(world)
        # where each drone has its velocities in qvel, (N, 6)
        self._dofs = np.array([drone.qvel_address for drone in world.drones])[:, None] + np.arange(6)
        self._times: list[float] = []
        self._samples = [GrowingBlock(part.copy_shape, np.uint8) for part in self._parts]
        self._qpos = GrowingBlock(world.data.qpos.shape)
        self._motion = GrowingBlock(self._dofs.shape)
        self._requests: list[int] = []  # before each sample
        self._journals: list[Journal] = []  # of the world, each once: another one after a return to a snapshot

    def sample(self) -> None:
        """Take one sample of the present instant."""
        self._times.append(self._world.time)
        for part, samples in zip(self._parts, self._samples, strict=True):
            part.refresh()
            part.copy(samples.add())
        self._qpos.add()[:] = self._world.data.qpos
        self._motion.add()[:] = self._world.data.qvel[self._dofs]
        self._requests.append(len(self._world.journal))
        if not self._journals or self._journals[-1] is not self._world.journal:
            self._journals.append(self._world.journal)

    def run(self, seconds: float) -> None:
        """Advance the world and sample on the way."""
        for _ in range(max(1, round(seconds * TICKS_PER_SECOND / self.ticks_per_sample))):
            self._world.step(self.ticks_per_sample)
            self.sample()

    @property
    def qpos(self) -> NDArray[np.float64]:
        """Positions of the whole model at each sample, shape (T, nq)."""
        return self._qpos.rows()

    @property
    def times(self) -> NDArray[np.float64]:
        """Simulated time of each sample (s), shape (T,)."""
        return np.array(self._times)

    def finish(self, metadata: Mapping[str, Any] | None = None) -> FlightLog:
        """Return everything recorded so far; the metadata also says what flew, how it was built, and the seed."""
        signals = {**self._signals(), **self._true_motion()}
        journal = self._world.journal.copy()
        journal.samples = list(self._requests)
        if len(self._journals) > 1:
            journal.gap = "the world was taken back in time while it was recorded"
        return FlightLog(
            time=self.times,
            drone_ids=[drone.id for drone in self._world.drones],
            signals=signals,
            metadata={**self._provenance(), **(metadata or {})},
            events=[event.as_dict() for event in self._world.events],
            journal=journal,
            scenery=self._scenery(),
        )

    def _scenery(self) -> NDArray[np.float32] | None:
        """Return what moves beside drones and mirrored bodies, shape (T, any), or None."""
        columns = scenery_columns(self._world.model, [drone.id for drone in self._world.drones])
        mirrored = scenery_columns(self._world.model, self._world.mirrored)
        columns = np.intersect1d(columns, mirrored)
        return self.qpos[:, columns].astype(np.float32) if len(columns) else None

    def _signals(self) -> dict[str, NDArray[Any]]:
        """Return every log variable of the swarm, shape (T, N)."""
        found: dict[str, list[tuple[NDArray[np.intp], NDArray[Any]]]] = {}
        for part, samples in zip(self._parts, self._samples, strict=True):
            for name, taken in part.signals(samples.rows()).items():
                found.setdefault(name, []).append((part.numbers, taken))
        return {name: _joined(own, len(self._world.drones)) for name, own in found.items()}

    def _provenance(self) -> dict[str, Any]:
        drones = {d.id: {"provider": d.config.provider, "platform": d.config.platform} for d in self._world.drones}
        return {
            **identity(),
            "scene": self._world.scene,
            "seed": self._world.seed,
            "drones": drones,
            "providers": provider_identities(self._world),
        }

    def _true_motion(self) -> dict[str, NDArray[np.float32]]:
        addresses = [drone.qpos_address for drone in self._world.drones]
        qpos = self.qpos
        pose = np.stack([qpos[:, address : address + 7] for address in addresses], axis=1)  # (T, N, 7)
        motion = self._motion.rows()  # (T, N, 6)
        angles = roll_pitch_yaw_deg(pose[..., 3:7])
        truth = {
            **{name: pose[..., i] for i, name in enumerate(_TRUE_POSE)},
            **{name: motion[..., i] for i, name in enumerate((*_TRUE_VELOCITY, *_TRUE_RATES))},
            **{name: angles[..., i] for i, name in enumerate(_TRUE_ATTITUDE)},
        }
        return {name: values.astype(np.float32) for name, values in truth.items()}


def provider_identities(world: World) -> list[dict[str, Any]]:
    """Return what flies the drones of a world, once per provider, in the order of the drones."""
    return [provider_identity(number) for number in dict.fromkeys(drone.provider_number for drone in world.drones)]


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


_PIECE_BYTES = 1 << 22  # NumPy asks for large pages from here on, in which memory that is new costs far less
_MAX_ROWS = 1024  # short rows need no piece of that size


class GrowingBlock:
    """Rows of one shape and type, in pieces of memory that stay where they are while it grows."""

    def __init__(self, shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> None:
        """Begin without a row.

        Args:
            shape: Of a row.
            dtype: Of its numbers.
        """
        self._shape = shape
        self._dtype = np.dtype(dtype)
        row_bytes = max(1, math.prod(shape) * self._dtype.itemsize)
        self._rows_per_piece = min(-(-_PIECE_BYTES // row_bytes), _MAX_ROWS)
        self._pieces: list[NDArray] = []
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self) -> NDArray:
        """Return another row, to be filled."""
        place = self._count % self._rows_per_piece
        if place == 0:
            self._pieces.append(np.empty((self._rows_per_piece, *self._shape), self._dtype))
        self._count += 1
        return self._pieces[-1][place]

    def rows(self) -> NDArray:
        """Return a copy of all rows, shape (rows, ...)."""
        if not self._pieces:
            return np.empty((0, *self._shape), self._dtype)
        *full, last = self._pieces
        return np.concatenate([*full, last[: self._count - len(full) * self._rows_per_piece]])
