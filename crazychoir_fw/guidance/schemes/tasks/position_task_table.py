"""`PositionTaskTable`: random points to be visited, always as many as there are agents.

docs/reference/crazychoir.md#17.5.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import DispatchTable
from crazychoir_fw.guidance.schemes.tasks.position_task import PositionTask

_MAX_DRAWS = 1000  # of one task, until an agent that is not gone can do it
_MAX_REMEMBERED = 1_000_000  # draws, some seconds


class PositionTaskTable(DispatchTable):
    """Draws points at random, each of which some agents can do, and a new one when one was visited.

    A point that no living agent can do is drawn again at once. Points that cannot all be assigned stay in the table:
    agents do as many as possible, and the rest after the next completion.
    """

    def __init__(
        self,
        N: int,
        *,
        seed: int = 4,
        low: ArrayLike = (-3.0, -3.0),
        high: ArrayLike = (3.0, 3.0),
        probability: float = 0.5,
        generations: int = 8,
        deadline: float = 1.0,
        patience: float = 30.0,
        start_delay: float = 0.5,
    ) -> None:
        """Prepare.

        Args:
            N: Number of agents, and of tasks.
            seed: Seed of the draws; with 4 and six agents the first tasks are those of the original.
            low: Least x and y of a task (m).
            high: Largest x and y (m).
            probability: That an agent can do a task, above 0.
            generations: How often tasks are drawn, the first time included.
            deadline: As of `DispatchTable`.
            patience: As of `DispatchTable`.
            start_delay: As of `DispatchTable`.

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(N, deadline=deadline, patience=patience, start_delay=start_delay)
        self.low, self.high = np.array(low, float), np.array(high, float)
        if self.low.shape != (2,) or self.high.shape != (2,) or not np.all(np.isfinite([self.low, self.high])):
            raise RangeError(f"task table: bounds are {low} and {high}, allowed: x and y each")
        if not np.all(self.low <= self.high):
            raise RangeError(f"task table: low is {low}, allowed: at most high, {high}")
        if not 0.0 < probability <= 1.0:
            raise RangeError(f"task table: probability is {probability}, allowed: (0, 1]")
        if generations < 1:
            raise RangeError(f"task table: generations is {generations}, allowed: 1 or more")
        self.probability = probability
        self.generations_left = int(generations)
        self.tasks: dict[int, PositionTask] = {}
        """Open tasks by their number."""
        # the generator of the original, whose numbers will never change
        self._random = np.random.RandomState(seed)
        self._next_sequence = 0
        self._draws = 0

    def _begin(self) -> None:
        self._generate()

    def _generate(self) -> None:
        """Fill the free places of the table."""
        if not self.generations_left:
            return
        self.generations_left -= 1
        self._fill([number for number in range(self.agents) if number not in self.tasks])

    def _fill(self, numbers: list[int]) -> None:
        made = []
        for number in numbers:
            task = self._drawn(number)
            self.tasks[number] = task
            made.append([task.number, task.sequence, *task.position, list(task.agents)])
        self.note("tasks", None, {"label": self.label + 1, "tasks": made})

    def _drawn(self, number: int) -> PositionTask:
        for _ in range(_MAX_DRAWS):
            point, chances = self._draw()
            position = self.low + (self.high - self.low) * point
            able = np.flatnonzero(chances < self.probability)
            if not self.gone.issuperset(able.tolist()):
                break
            self.note("redrawn", None, {"number": number, "label": self.label + 1})
        else:
            able = np.array(sorted(self._living))  # all but never
        task = PositionTask(
            number, self._next_sequence, (float(position[0]), float(position[1])), tuple(int(one) for one in able)
        )
        self._next_sequence += 1
        return task

    def _draw(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        self._draws += 1
        return self._random.random_sample(2), self._random.random_sample(self.agents)

    def _items_of(self, agent: int) -> list[PositionTask]:
        return [task for _, task in sorted(self.tasks.items()) if agent in task.agents]

    def _finish(self, agent: int, number: int) -> bool:
        task = next((task for task in self.tasks.values() if task.sequence == number), None)
        if task is None or agent not in task.agents:
            return False
        del self.tasks[task.number]
        self.finished += 1
        self.note("completed", agent, {"number": number, "position": list(task.position)})
        self._generate()
        self.announce()
        return True

    def _take_back(self) -> bool:
        lonely = [number for number, task in sorted(self.tasks.items()) if self.gone.issuperset(task.agents)]
        if not lonely:
            return False
        self.note("returned", None, {"numbers": [self.tasks[number].sequence for number in lonely]})
        for number in lonely:
            del self.tasks[number]
        self._fill(lonely)
        return True

    @property
    def _open(self) -> set[int]:
        return {task.sequence for task in self.tasks.values()}

    def _memory(self) -> dict[str, Any]:
        tasks = [[task.number, task.sequence, list(task.position), list(task.agents)] for task in self.tasks.values()]
        return {
            "tasks": tasks,
            "generations_left": self.generations_left,
            "next_sequence": self._next_sequence,
            "draws": self._draws,
        }

    def _remember(self, memory: Mapping[str, Any]) -> None:
        tasks = {}
        for number, sequence, (x, y), able in memory["tasks"]:
            if not (0 <= number < self.agents and set(able) <= set(range(self.agents)) and math.isfinite(x + y)):
                raise ValueError(f"task {number} at ({x}, {y}) for {able}")
            tasks[int(number)] = PositionTask(int(number), int(sequence), (float(x), float(y)), tuple(able))
        left, sequence, draws = (int(memory[name]) for name in ("generations_left", "next_sequence", "draws"))
        if left < 0 or not 0 <= sequence <= draws <= _MAX_REMEMBERED:
            raise ValueError(f"{left} generations left, {sequence} tasks, {draws} draws")
        while self._draws < draws:
            self._draw()
        self.tasks, self.generations_left, self._next_sequence = tasks, left, sequence
