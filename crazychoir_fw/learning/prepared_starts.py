"""Starts of the next episodes of each flight, worked out many at a time.

A start depends on the seed of a flight and the number of its episode alone, so it can be known before it is needed. For
a single flight NumPy takes two hundred microseconds, for 32 of them hardly more.
"""

from __future__ import annotations

from typing import Any

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
        self.ahead = _AHEAD if task.starts_alone else 1
        """Episodes of each flight that are prepared together."""
        self._seeds = np.arange(count, dtype=np.uint64)
        self.episodes = np.zeros(count, np.int64)
        """The next one of each flight; C counts them."""
        self._known = np.zeros(count, np.int64)  # episodes below it are prepared
        self.rows = np.zeros((count * self.ahead, _NUMBERS + 1 + task.plan_size))
        """For each flight `ahead` rows: a start as C reads it, the number of its pattern, and the plan."""

    def seed(self, seeds: NDArray[np.uint64]) -> None:
        """Give each flight a seed, shape (N,), and begin with its first episode."""
        self._seeds = seeds
        self.episodes[:] = self._known[:] = 0

    def prepare(self, which: NDArray[np.int32]) -> None:
        """See that `rows` has the next episode of some flights, by their numbers, shape (n,)."""
        is_used_up = self.episodes.take(which) >= self._known.take(which)
        if is_used_up.any():
            self._prepare(which[is_used_up])

    def next_patterns(self, which: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the numbers of the patterns of the next episodes, shape (n,)."""
        return self.rows[self._places(which), _NUMBERS].astype(np.int32)

    def next_starts(self, which: NDArray[np.int32]) -> NDArray[Any]:
        """Return how the next episodes begin, of type `START`, shape (n,)."""
        return self.rows[self._places(which), :_NUMBERS].copy().view(START)[:, 0]

    def _places(self, which: NDArray[np.int32]) -> NDArray[np.int64]:
        return which * self.ahead + self.episodes.take(which) % self.ahead

    def _prepare(self, which: NDArray[np.int32]) -> None:
        episodes = self._known[which][:, None] + np.arange(self.ahead)
        keys = episode_keys(np.repeat(self._seeds[which], self.ahead), episodes.ravel().astype(np.uint64))
        drawn, starts = self._task.starts(keys), np.zeros(len(keys), START)
        for name in ("position", "quat_wxyz", "velocity", "rates"):
            starts[name] = getattr(drawn, name)
        starts["seed"] = mixed(keys)
        numbers = starts.view(np.float64).reshape(len(keys), _NUMBERS)
        patterns = np.floor(uniforms(keys, 1, _PATTERN) * self._patterns)
        places = (which[:, None] * self.ahead + np.arange(self.ahead)).ravel()
        self.rows[places] = np.hstack([numbers, patterns, self._task.plan(keys)])
        self._known[which] += self.ahead
