"""Starts of the next episodes of each flight, worked out many at a time.

A start depends on the seed of a flight and the number of its episode alone, so it can be known before it is needed. For
a single flight NumPy takes two hundred microseconds, for 32 of them hardly more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi
from crazychoir_fw.learning.dice import episode_keys, mixed, uniforms
from crazychoir_fw.learning.tasks.task import Task

_AHEAD = 32  # episodes of each flight, of a task whose flights start by themselves
_PATTERN = 2  # stream of dice that chooses the pattern of an episode

START = np.dtype(
    [
        *(("position", "f8", 3), ("quat_wxyz", "f8", 4), ("velocity", "f8", 3), ("rates", "f8", 3)),
        *(("seed", "u8"), ("id", "u8")),
    ]
)
"""``cf_flight_start_t``."""
assert START.itemsize == ffi.sizeof("cf_flight_start_t")
_NUMBERS = START.itemsize // 8


class PreparedStarts:
    """For each of N flights, how its next episodes begin."""

    def __init__(self, task: Task, count: int, patterns: int) -> None:
        """Prepare nothing yet.

        Args:
            task: Draws the starts.
            count: Number of flights.
            patterns: Number of drones of which an episode begins as a copy.
        """
        self._task = task
        self._patterns = patterns
        self._ahead = _AHEAD if task.starts_alone else 1
        self._seeds = np.arange(count, dtype=np.uint64)
        self._next = np.zeros(count, np.int64)  # episode
        self._known = np.zeros(count, np.int64)  # episodes below it are prepared
        # a start as C reads it, the number of its pattern, and the plan: one row, because each access costs as much
        self._rows = np.zeros((count * self._ahead, _NUMBERS + 1 + task.plan_size))

    def seed(self, seeds: NDArray[np.uint64]) -> None:
        """Give each flight a seed, shape (N,), and begin with its first episode."""
        self._seeds = seeds
        self._next[:] = self._known[:] = 0

    def take(self, which: NDArray[np.int32]) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
        """Return how the next episodes of some flights begin, and count them.

        Args:
            which: Numbers of flights, shape (n,).

        Returns:
            Bytes of ``cf_flight_start_t`` as numbers, shape (n, 15), patterns, shape (n,), and plans, (n, k).
        """
        episodes = self._next.take(which)
        is_used_up = episodes >= self._known.take(which)
        if is_used_up.any():
            self._prepare(which[is_used_up])
        self._next[which] = episodes + 1
        rows = self._rows.take(which * self._ahead + episodes % self._ahead, axis=0)
        return rows[:, :_NUMBERS].copy(), rows[:, _NUMBERS].astype(np.int32), rows[:, _NUMBERS + 1 :]

    def _prepare(self, which: NDArray[np.int32]) -> None:
        episodes = self._known[which][:, None] + np.arange(self._ahead)
        keys = episode_keys(np.repeat(self._seeds[which], self._ahead), episodes.ravel().astype(np.uint64))
        drawn, starts = self._task.starts(keys), np.zeros(len(keys), START)
        for name in ("position", "quat_wxyz", "velocity", "rates"):
            starts[name] = getattr(drawn, name)
        starts["seed"] = mixed(keys)
        numbers = starts.view(np.float64).reshape(len(keys), _NUMBERS)
        patterns = np.floor(uniforms(keys, 1, _PATTERN) * self._patterns)
        places = (which[:, None] * self._ahead + np.arange(self._ahead)).ravel()
        self._rows[places] = np.hstack([numbers, patterns, self._task.plan(keys)])
        self._known[which] += self._ahead
