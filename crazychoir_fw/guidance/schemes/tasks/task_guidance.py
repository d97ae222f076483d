"""`TaskGuidance`: dynamic task assignment (docs/reference/crazychoir.md#17.5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.optimization import LinearProblem, assigned_task, assignment_problem
from crazychoir_fw.guidance.schemes.tasks.dispatch_guidance import DispatchGuidance, LabeledSimplex
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import Offer
from crazychoir_fw.guidance.schemes.tasks.position_task import PositionTask
from crazychoir_fw.guidance.schemes.tasks.position_task_executor import PositionTaskExecutor


class TaskGuidance(DispatchGuidance):
    """Shares out the tasks of a `PositionTaskTable`, one per drone, at the least sum of distances, and visits them.

    Who gets no task, since it can do none or there are not enough for all, hovers.
    """

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        *,
        init_pos: ArrayLike | None = None,
        height: float = 0.5,
        height_step: float = 0.15,
        takeoff_time: float = 5.0,
        update_frequency: float = 100.0,
        deadline: float = 0.05,
        max_iterations: int = 20,
        tolerance: float = 0.05,
        speed: float = 0.5,
        duration: float | None = None,
        big_M: float = 500.0,
    ) -> None:
        """Prepare.

        Args:
            agent_id: As of `DispatchGuidance`, like the following ones.
            communicator: Carries bases to and from neighbors.
            init_pos: Start (m, world), shape (2,) or (3,).
            height: At which drone 0 flies (m).
            height_step: So much higher flies each further drone (m).
            takeoff_time: Of take-off and landing (s).
            update_frequency: Steps per second (Hz).
            deadline: How long a round may take (s).
            max_iterations: Rounds of an optimization, at least the longest way between two drones in the graph.
            tolerance: Level distance from its point at which a task is done (m).
            speed: Mean speed of flights (m/s).
            duration: Duration of every flight (s), instead of the speed.
            big_M: What a task costs that nobody does: more than half of what all flights together may cost (m).

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(
            agent_id,
            communicator,
            init_pos=init_pos,
            height=height,
            height_step=height_step,
            takeoff_time=takeoff_time,
            update_frequency=update_frequency,
            deadline=deadline,
            max_iterations=max_iterations,
            big_M=big_M,
        )
        self.executor = PositionTaskExecutor(self.height, tolerance=tolerance, speed=speed, duration=duration)
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

    def decide(self, simplex: LabeledSimplex, now: float) -> bool:
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
            return  # it was told to land while an optimization ran
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
