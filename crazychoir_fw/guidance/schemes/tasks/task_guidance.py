"""`TaskGuidance`: dynamic task assignment (docs/reference/crazychoir.md#17.5)."""

from __future__ import annotations

from typing import Any

import numpy as np

from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.law import Needs
from crazychoir_fw.guidance.optimization import LinearProblem, assigned_task, assignment_problem
from crazychoir_fw.guidance.schemes.tasks.dispatch_guidance import DispatchGuidance, LabeledSimplex
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import Offer
from crazychoir_fw.guidance.schemes.tasks.position_task import PositionTask
from crazychoir_fw.guidance.schemes.tasks.task_metrics import TaskMetrics


class TaskGuidance(DispatchGuidance):
    """Shares out the tasks of a `PositionTaskTable`, one per drone, at the least sum of distances, and visits them.

    A drone without a task hovers: it can do none, or there are not enough tasks for all.
    """

    needs = Needs(graph=True, table="tasks")
    metrics = TaskMetrics

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`."""
        super().__init__(agent_id, communicator, **options)
        self.task: PositionTask | None = None
        """What it does at present."""
        self._done: set[int] = set()
        self._offered: dict[int, tuple[PositionTask, float]] = {}  # tasks and their costs by number

    def problem(self, offer: Offer, now: float) -> LinearProblem:
        """Return its columns: one per task that it can do, which costs the level distance (m)."""
        del now
        here = self._position()[:2]
        tasks: list[PositionTask] = list(offer.items)
        costs = [float(np.hypot(*(np.array(task.position) - here))) for task in tasks]
        self._offered = {task.number: (task, cost) for task, cost in zip(tasks, costs, strict=True)}
        return assignment_problem(self.agent_id, self.communicator.size, [task.number for task in tasks], costs)

    def conclude(self, simplex: LabeledSimplex, now: float) -> bool:
        """Go to the task that it got, or stay."""
        number = assigned_task(simplex, self.communicator.size)
        # it may have arrived while the optimization ran
        chosen = None if number is None else self._offered[number][0]
        self.task = None if chosen is None or chosen.sequence in self._done else chosen
        costs = [[task.sequence, cost] for task, cost in self._offered.values()]
        takes = [] if self.task is None else [self.task.sequence]
        self._tell(takes, takes, costs=costs, rounds=simplex.rounds)
        self._move(now)
        return True

    def _move(self, now: float) -> None:
        if self._phase is not Phase.FLIGHT:
            return  # a landing was commanded while an optimization ran
        here = self._position()
        way = self.executor.stay(here) if self.task is None else self.executor.go(self.task.position, here, now)
        if way is not None:
            self.go_to(*way)

    def work(self, now: float) -> None:
        """See whether it is there, and say so."""
        task = self.task
        if task is None or self._desk is None or self.is_deciding:
            return
        if self.executor.has_arrived(self._position()):
            self.task = None
            # it waits there
            self.executor.goal = None
            self._done.add(task.sequence)
            self._desk.complete(self.agent_id, task.sequence)
        elif self.executor.is_late(now):
            x, y = task.position
            self.task = None
            self._give_up(f"did not reach task {task.sequence} at ({x:.2f}, {y:.2f})")

    def forget_what_was_said(self) -> None:
        """See `DispatchGuidance`."""
        self._done.clear()

    def drop(self) -> None:
        """See `DispatchGuidance`."""
        self.task = None
        self.executor.goal = None
