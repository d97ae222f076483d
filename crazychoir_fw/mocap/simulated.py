"""`SimulatedMocap`: true poses as a motion-capture system would see and tell them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.onboard.core import check

Array = NDArray[np.float64]

_BLOCK = 64
_NORMALS, _CHANCES = 9, 3  # per frame and drone

_GRID = 1e-9  # [s], by which a sample may be early: times are sums of steps


@dataclass(frozen=True, kw_only=True)
class MocapConfig:
    """How well the system sees. `MocapConfig.default()` has the numbers of the vehicle model."""

    rate: float
    """Frames per second (Hz)."""
    latency: float
    """Time from a frame to its arrival (s)."""
    position_noise: float
    """Standard deviation per axis (m)."""
    attitude_noise: float
    """Standard deviation per axis (rad)."""
    dropout: float
    """Probability that a drone is missing in a frame, in [0, 1]."""
    outlier: float
    """Probability that a wrong marker is taken, in [0, 1]."""
    outlier_size: float
    """Outliers are off by a quarter of it to all of it (m)."""

    @classmethod
    def default(cls) -> MocapConfig:
        """Return what simulated vehicles have, by default."""
        config = ffi.new("cf_vehicle_config_t *")
        check(lib.cf_vehicle_default_config(config, lib.CF_PLATFORM_CF2), "vehicle")
        mocap = config.mocap
        return cls(
            rate=float(mocap.rate),
            latency=1e-3 * mocap.latency_ms,
            position_noise=round(mocap.position_noise, 9),  # a float of 32 bits
            attitude_noise=round(mocap.attitude_noise, 9),
            dropout=round(mocap.mishap.dropout, 9),
            outlier=round(mocap.mishap.outlier, 9),
            outlier_size=round(mocap.mishap.outlier_size, 9),
        )

    def __post_init__(self) -> None:
        for name in ("rate", "latency", "position_noise", "attitude_noise", "dropout", "outlier", "outlier_size"):
            value = getattr(self, name)
            high = 1.0 if name in ("dropout", "outlier") else math.inf
            if not (math.isfinite(value) and 0.0 <= value <= high) or (name == "rate" and value == 0.0):
                allowed = "above 0 Hz" if name == "rate" else "0 to 1" if high == 1.0 else "0 or more"
                raise RangeError(f"{name} is {value}, allowed: {allowed}")


class SimulatedMocap:
    """Turns true poses into samples: at a rate, noisy, late, and now and then lost or wrong.

    For one drone or for several; the random numbers of a drone depend on the seed and on its index alone. The number of
    drones and the losses of others do not change them.
    """

    def __init__(self, config: MocapConfig | None = None, *, seed: int = 0, first: int = 0) -> None:
        """Choose the system.

        Args:
            config: How well it sees; None has the numbers of the vehicle model.
            seed: Seed of the random numbers.
            first: Index of the first drone: a caller with one object per drone gets the same noise as for a group.
        """
        self.config = MocapConfig.default() if config is None else config
        self.occluded: set[int] = set()
        """Indices of the drones that the cameras do not see; 0 where there is one. May be changed at any time."""
        self._seed, self._index = seed, first
        self.reset()

    def reset(self) -> None:
        """Begin again, with the same random numbers."""
        self._first: float | None = None
        self._frames = 0
        self._dice: list[np.random.Generator] = []
        self._drawn = np.zeros((0, _BLOCK, _NORMALS + _CHANCES))
        self._next = 0
        self._under_way: deque[Pose] = deque()

    def occlude(self, indices: Iterable[int]) -> None:
        """Hide drones from the cameras."""
        self.occluded.update(indices)

    def reveal(self, indices: Iterable[int]) -> None:
        """Show them again."""
        self.occluded.difference_update(indices)

    def step(self, now: float, truth: Pose) -> list[Pose]:
        """Say where the drones are, as often as it is known, and take what arrives.

        Args:
            now: Time (s), not before that of the last call. A frame is taken at the first call, and then at the first
                one at or after each frame time.
            truth: Position and orientation, shape (..., 3) and (..., 4).

        Returns:
            Samples that have arrived, the oldest first: noisy position and orientation with the time of their frame.
            Lost ones are NaN.

        Raises:
            RangeError: If the number of drones changes.
        """
        if self._first is None:
            self._first = now
        due = self._first + self._frames / self.config.rate
        if now >= due - _GRID:
            self._under_way.append(self._frame(now, truth))
            # one frame, however long ago the last call was
            self._frames = math.floor((now - self._first + _GRID) * self.config.rate) + 1
        arrived = []
        while self._under_way and now >= self._under_way[0].time + self.config.latency - _GRID:
            arrived.append(self._under_way.popleft())
        return arrived

    def _frame(self, now: float, truth: Pose) -> Pose:
        position, orientation = np.array(truth.position, float), np.array(truth.orientation, float)
        rows, attitudes = position.reshape(-1, 3), orientation.reshape(-1, 4)
        config, drawn = self.config, self._draw(len(rows))
        noise, turns, wrong, chances = drawn[:, 0:3], drawn[:, 3:6], drawn[:, 6:9], drawn[:, 9:12]
        rows += config.position_noise * noise
        attitudes[:] = _turned_slightly(attitudes, config.attitude_noise * turns)
        if config.outlier > 0.0:
            far = config.outlier_size * (0.25 + 0.75 * chances[:, 2]) / np.linalg.norm(wrong, axis=-1)
            rows += np.where((chances[:, 1] < config.outlier)[:, None], far[:, None] * wrong, 0.0)
        lost = chances[:, 0] < config.dropout
        lost[[i for i in self.occluded if i < len(rows)]] = True
        rows[lost], attitudes[lost] = np.nan, np.nan
        return Pose(position=position, orientation=orientation, time=now)

    def _draw(self, count: int) -> Array:
        """Return the random numbers of a frame: all of them, so that a loss does not change the noise after it."""
        if not self._dice:
            self._dice = [np.random.default_rng([self._seed, self._index + i]) for i in range(count)]
        if len(self._dice) != count:
            raise RangeError(f"number of drones is {count}, allowed: {len(self._dice)}, as in the first frame")
        if self._next == 0:
            self._drawn = np.stack([_block(dice) for dice in self._dice])
        row = self._drawn[:, self._next]
        self._next = (self._next + 1) % _BLOCK
        return row


def _block(dice: np.random.Generator) -> Array:
    # many frames at once: calls cost more than numbers
    return np.concatenate([dice.standard_normal((_BLOCK, _NORMALS)), dice.random((_BLOCK, _CHANCES))], axis=-1)


def _turned_slightly(q: Array, turn: Array) -> Array:
    """Return quaternions (xyzw), shape (n, 4), behind small rotations (rad, body), shape (n, 3)."""
    x, y, z, w = q.T
    a, b, c = 0.5 * turn.T
    turned = np.array(
        [x + w * a + y * c - z * b, y + w * b + z * a - x * c, z + w * c + x * b - y * a, w - x * a - y * b - z * c]
    )
    return (turned / np.sqrt(np.sum(turned * turned, axis=0))).T
