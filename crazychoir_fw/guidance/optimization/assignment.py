"""Assignment of tasks to agents, as a linear program for `DistributedSimplex` (docs/reference/crazychoir.md#17.5).

Each agent does one task, each task is done by one agent, at the least sum of costs. An agent's columns are the tasks it
can do. Where not all can be served, as many as possible are, and the others get none.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization.distributed_simplex import DistributedSimplex, LinearProblem


def assignment_problem(
    agent: int, agents: int, tasks: Sequence[int], costs: ArrayLike, number_of_tasks: int | None = None
) -> LinearProblem:
    """Return one agent's part.

    Args:
        agent: Its number, [0, agents - 1].
        agents: How many there are.
        tasks: Numbers of the tasks that it can do, [0, number_of_tasks - 1]; may be empty.
        costs: What each would cost, shape (len(tasks),); below half of the simplex' big_M.
        number_of_tasks: How many there are for all; None: as many as agents.

    Raises:
        RangeError: If a number is outside its range, or a task is named twice.
    """
    number_of_tasks = agents if number_of_tasks is None else number_of_tasks
    if not 0 <= agent < agents:
        raise RangeError(f"assignment: agent is {agent}, allowed: [0, {agents - 1}]")
    numbers = np.array(tasks, dtype=np.intp).reshape(-1)
    if len(set(numbers.tolist())) != len(numbers) or np.any((numbers < 0) | (numbers >= number_of_tasks)):
        raise RangeError(
            f"assignment: tasks of agent {agent} are {list(tasks)}, allowed: [0, {number_of_tasks - 1}], each once"
        )
    columns = np.zeros((agents + number_of_tasks, len(numbers)))
    columns[agent] = 1.0
    columns[agents + numbers, np.arange(len(numbers))] = 1.0
    return LinearProblem(costs, columns, np.ones(agents + number_of_tasks))


def assignments(simplex: DistributedSimplex, agents: int) -> dict[int, int]:
    """Return task by agent, as far as the agent that runs the simplex knows, without agents that get none."""
    found = {}
    for column, value in zip(simplex.B.T, simplex.x_basic, strict=True):
        doers = np.flatnonzero(column[1 : agents + 1])
        tasks = np.flatnonzero(column[agents + 1 :])
        if value > 0.5 and doers.size == 1 and tasks.size == 1:
            found[int(doers[0])] = int(tasks[0])
    return dict(sorted(found.items()))


def assigned_task(simplex: DistributedSimplex, agents: int) -> int | None:
    """Return the task of the agent that runs the simplex; None: it gets none."""
    return assignments(simplex, agents).get(simplex.agent.id)
