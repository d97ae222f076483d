"""Spaces of a task, and tasks by name or with changed fields."""

from __future__ import annotations

import dataclasses
from difflib import get_close_matches
from typing import Any

import numpy as np
from gymnasium import spaces

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.learning import tasks
from crazychoir_fw.learning.flights import Flights
from crazychoir_fw.learning.tasks.task import Task


def task_of(given: Task | type[Task] | str, changes: dict[str, Any]) -> Task:
    """Return a task.

    Args:
        given: A task, its class, or the name of one of `crazychoir_fw.learning.tasks`.
        changes: Fields that differ.

    Raises:
        UnknownNameError: If there is no such task, or it has no such field.
    """
    if isinstance(given, str):
        if given not in tasks.names():
            raise UnknownNameError(f"there is no task '{given}', allowed: {', '.join(tasks.names())}")
        given = getattr(tasks, given)
    kind = given if isinstance(given, type) else type(given)
    if not (isinstance(kind, type) and issubclass(kind, Task)):
        raise RangeError(f"task is {given!r}, allowed: a Task, its class or its name")
    known = [field.name for field in dataclasses.fields(kind)]
    for name in changes:
        if name not in known:
            near = get_close_matches(name, known, 1)
            hint = f", did you mean '{near[0]}'?" if near else ""
            raise UnknownNameError(f"{kind.__name__} has no field '{name}'{hint} Allowed: {', '.join(known)}")
    if isinstance(given, Task):
        return dataclasses.replace(given, **changes)
    return kind(**changes)


def _box(size: int) -> spaces.Box:
    return spaces.Box(-np.inf, np.inf, (size,), np.float32)


def observation_space(task: Task) -> spaces.Space[Any]:
    """Return the space of one flight's observations."""
    parts: dict[str, spaces.Space[Any]] = {"policy": _box(task.observation.size)}
    if task.critic is not None:
        parts["critic"] = _box(task.critic.size)
    if task.camera is not None:
        top = 255 if task.camera.kind == "image" else task.camera.far_m
        parts["camera"] = spaces.Box(0, top, task.camera.shape, task.camera.dtype)
    return spaces.Dict(parts) if len(parts) > 1 else parts["policy"]


def action_space(task: Task) -> spaces.Box:
    """Return the space of one flight's actions."""
    return spaces.Box(-1.0, 1.0, (task.action.size,), np.float32)


def observations(flights: Flights) -> Any:
    """Return the observations of all flights, as the batched space has them."""
    beside = {"critic": flights.observe_critic(), "camera": flights.see()}
    parts = {name: seen for name, seen in beside.items() if seen is not None}
    return {**parts, "policy": flights.observe()} if parts else flights.observe()
