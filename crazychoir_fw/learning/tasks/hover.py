"""Hover at a point, from random starts around it."""

from __future__ import annotations

from dataclasses import dataclass

from crazychoir_fw.learning.tasks.task import Task


@dataclass(frozen=True)
class Hover(Task):
    """Fly to `center` and stay there."""
