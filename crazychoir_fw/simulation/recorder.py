"""Records every log variable of every drone, and the true motion, at a fixed rate.

A log variable is one number at a fixed place of each drone's memory, so that one strided view of `plugin_state` is
that variable of the whole swarm: a sample costs one array copy per variable, whatever the number of drones.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.core import identity
from crazychoir_fw.errors import RangeError
from crazychoir_fw.report.flight_log import FlightLog
from crazychoir_fw.simulation.world import TICKS_PER_SECOND, World
from crazychoir_fw.variables import log_table

_TRUE_POSE = ("sim.x", "sim.y", "sim.z")
_TRUE_VELOCITY = ("sim.vx", "sim.vy", "sim.vz")
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
        self._views = swarm_views(world)
        self._stride = _stride(world)
        self._times: list[float] = []
        self._samples: dict[str, list[NDArray]] = {name: [] for name in self._views}
        self._qpos: list[NDArray[np.float64]] = []
        self._motion: list[NDArray[np.float64]] = []

    def sample(self) -> None:
        """Take one sample of the present instant."""
        lib.cf_refresh_logs(self._world.drones[0].struct, len(self._world.drones), self._stride)
        self._times.append(self._world.time)
        for name, view in self._views.items():
            self._samples[name].append(view.copy())
        self._qpos.append(self._world.data.qpos.copy())
        self._motion.append(np.array([drone.true_velocity for drone in self._world.drones]))

    def run(self, seconds: float) -> None:
        """Advance the world and sample on the way."""
        for _ in range(max(1, round(seconds * TICKS_PER_SECOND / self.ticks_per_sample))):
            self._world.step(self.ticks_per_sample)
            self.sample()

    @property
    def qpos(self) -> NDArray[np.float64]:
        """Positions of the whole model at each sample, shape (T, nq): what a film is made of."""
        return np.array(self._qpos)

    @property
    def times(self) -> NDArray[np.float64]:
        """Simulated time of each sample (s), shape (T,)."""
        return np.array(self._times)

    def finish(self, metadata: Mapping[str, Any] | None = None) -> FlightLog:
        """Return everything recorded so far; the metadata also says what flew, how it was built, and the seed."""
        signals = {name: np.array(samples) for name, samples in self._samples.items()}
        signals.update(self._true_motion())
        return FlightLog(
            time=self.times,
            drone_ids=[drone.id for drone in self._world.drones],
            signals=signals,
            metadata={**self._provenance(), **(metadata or {})},
        )

    def _provenance(self) -> dict[str, Any]:
        drones = {d.id: {"provider": d.config.provider, "platform": d.config.platform} for d in self._world.drones}
        return {**identity(), "scene": self._world.scene, "seed": self._world.seed, "drones": drones}

    def _true_motion(self) -> dict[str, NDArray[np.float32]]:
        addresses = [drone.qpos_address for drone in self._world.drones]
        qpos = self.qpos
        pose = np.stack([qpos[:, address : address + 7] for address in addresses], axis=1)  # (T, N, 7)
        velocity = np.array(self._motion)  # (T, N, 3)
        angles = roll_pitch_yaw_deg(pose[..., 3:7])
        truth = {
            **{name: pose[..., i] for i, name in enumerate(_TRUE_POSE)},
            **{name: velocity[..., i] for i, name in enumerate(_TRUE_VELOCITY)},
            **{name: angles[..., i] for i, name in enumerate(_TRUE_ATTITUDE)},
        }
        return {name: values.astype(np.float32) for name, values in truth.items()}


def _stride(world: World) -> int:
    """Return how far apart the drones stand in memory (bytes)."""
    starts = [drone.memory.ctypes.data for drone in world.drones]
    strides = set(np.diff(starts)) or {world.drones[0].memory.nbytes}
    if len(strides) != 1:
        raise RangeError("other engine plugins stand between the drones, they cannot be recorded together")
    return int(strides.pop())


def swarm_views(world: World) -> dict[str, NDArray]:
    """Return each log variable of all drones as a live view of the world's memory, shape (N,).

    The drones must carry the same provider, and nothing else may stand between them in `plugin_state`. The
    groups `stateEstimateZ` and `ctrltargetZ` are as old as the latest call of `cf_refresh_logs`.
    """
    first = world.drones[0].memory
    count, stride = len(world.drones), _stride(world)
    views = {}
    for name, variable in log_table(world.drones[0].struct.config.provider).items():
        end = variable.offset + variable.dtype.itemsize
        cell = first[variable.offset : end].view(variable.dtype)
        views[name] = as_strided(cell, shape=(count,), strides=(stride,), writeable=False)
    return views


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
